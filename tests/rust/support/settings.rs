//! Every technique with many settings.

use shadowlab::Error;
use shadowlab::techniques::{self, Kind, Technique, Value, technique_of};

/// The techniques that are for what is seen alone: they have no map for the body, and look for their own.
pub const BY_SAMPLES: [&str; 3] = ["scene_optimal", "rectilinear", "optimal_partition"];

/// Settings that depend on each other.
const TOGETHER: [&str; 26] = [
    "lispsm:near=optimal,norm=mean,axis=middle,near_weight=1e6",
    "lispsm:near=optimal,norm=linf,axis=middle,near_weight=1e-6,fit=intersection",
    "lispsm:near=optimal,over=body,norm=storage,range=body,fit=exact",
    "lispsm:near=optimal,norm=edge,range=body,fit=exact,near_factor=0.5",
    "lispsm:near=delta-z,range=body,fit=shadow,margin=0",
    "lispsm:near=basic,range=seen,fit=exact",
    "tsm:range=body,fit=seen,margin=16",
    "uniform:focus=frustum,range=seen,fit=shadow",
    "z_partition:count=3,range=seen,inner=(uniform:range=seen,fit=seen)/lispsm",
    "z_partition:count=3,inner=(lispsm:near=optimal)",
    "z_partition:splits=min-max,cover=samples",
    "z_partition:splits=equal-log,cover=samples,inner=lispsm",
    "z_partition:splits=equal-log,count=16",
    "z_partition:count=3,overlap=0.3,inner=(lispsm:near=basic)/uniform",
    "z_partition:count=2,stable=true,inner=uniform:focus=frustum",
    "z_partition:distances=(0.5,20),range=camera,inner=uniform:focus=frustum",
    "z_partition:count=2,inner=face_partition",
    "z_partition:count=2,inner=(z_partition:count=2,splits=uniform)",
    "face_partition:inner=(z_partition:count=2)/uniform",
    "face_partition:inner=uniform:focus=none",
    "z_partition:count=2,inner=rectilinear/uniform",
    "face_partition:inner=rectilinear",
    "rectilinear:base=(uniform:turn=rectangle),fit=seen,range=body",
    "rectilinear:base=(uniform:focus=none),bins=3,cap=none",
    "optimal_partition:count=2,fit=seen,slack=1.5",
    "optimal_partition:count=3,objective=l1,cap=none",
];

/// Techniques whose maps are no base of another: a warp follows after their projection already, or they divide the view.
const NO_BASE: [&str; 3] = ["log_psm", "log", "optimal_partition"];

/// Every technique with its defaults, with each word, flag and a few numbers of each parameter, and settings that belong
/// together.
pub fn settings() -> Vec<(String, Box<dyn Technique>)> {
    let mut all = Vec::new();
    for spec in techniques::specs() {
        let mut add = |params: &[(String, Value)]| {
            let shown: Vec<String> = params.iter().map(|(n, v)| format!("{n}={v}")).collect();
            match techniques::technique(spec.name, params) {
                Ok(t) => all.push((format!("{}({})", spec.name, shown.join(",")), t)),
                // A value may need another beside it; it has its line above then.
                Err(Error::InvalidArgument { name, .. }) if params.iter().any(|(n, _)| *n == name) => {
                    let assigned = params.iter().map(|(n, v)| format!("{n}={v}").replace('"', ""));
                    let together =
                        |text: &&str| text.starts_with(spec.name) && assigned.clone().all(|a| text.contains(&a));
                    assert!(TOGETHER.iter().any(together), "{}({})", spec.name, shown.join(","));
                }
                Err(error) => panic!("{}({}): {error}", spec.name, shown.join(",")),
            }
        };
        add(&[]);
        // Its maps are those of scene_optimal, which has all settings, and it makes many of them to choose from.
        if spec.name == "optimal_partition" {
            continue;
        }
        for p in spec.params {
            let is_none =
                |v: &Value| p.name == "base" && NO_BASE.iter().any(|name| *v == Value::Choice((*name).into()));
            for value in values_of(&p.kind).into_iter().filter(|v| *v != p.default.value() && !is_none(v)) {
                add(&[(p.name.to_string(), value)]);
            }
        }
    }
    all.extend(TOGETHER.map(|text| (text.to_string(), technique_of(text).expect(text))));
    all
}

fn values_of(kind: &Kind) -> Vec<Value> {
    let mut values: Vec<Value> = Vec::new();
    if let Kind::Choice(words) | Kind::ChoiceOrNumber { words, .. } | Kind::Numbers { words, .. } = *kind {
        values.extend(words.iter().map(|w| Value::Choice(w.to_string())));
    }
    if let Kind::Number { min, max } | Kind::ChoiceOrNumber { min, max, .. } = *kind {
        let probes: [f64; 5] = [0.0, 1e-3, 0.1, 10.0, 1e9];
        values.extend(probes.iter().map(|x| Value::Number(x.clamp(min, max))));
        values.extend([Value::Number(min), Value::Number(max)]);
    }
    match *kind {
        Kind::Flag => values.extend([Value::Flag(true), Value::Flag(false)]),
        Kind::Integer { min, max } => {
            values.extend([min, min.midpoint(max), max].map(Value::Integer));
        }
        Kind::Numbers { count: [fewest, most], min, max, .. } => {
            let lists = [fewest, (fewest + 1).min(most), most.min(8)];
            let ascending = |n: usize| (0..n).map(|i| (0.5 * 4_f64.powi(i as i32)).clamp(min, max)).collect();
            values.extend(lists.map(|n| Value::Numbers(ascending(n))));
        }
        // Each by itself, but for those that would nest in themselves: they have their lines among [`TOGETHER`].
        Kind::Techniques | Kind::Technique => values.extend(
            techniques::specs()
                .filter(|spec| spec.params.iter().all(|p| !matches!(p.kind, Kind::Techniques | Kind::Technique)))
                .filter(|spec| spec.name != "optimal_partition")
                .map(|spec| Value::Choice(spec.name.to_string())),
        ),
        Kind::Number { .. } | Kind::Choice(_) | Kind::ChoiceOrNumber { .. } => {}
    }
    values.dedup();
    values
}
