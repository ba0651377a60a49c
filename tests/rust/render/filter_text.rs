//! Filters as text: what is read is written again, and what is wrong is named.

use shadowlab::Error;
use shadowlab::render::{Extent, FILTERS, Filter};

use crate::support::cpu::FILTERS as TEXTS;

#[test]
fn texts_read_as_they_are_written() {
    for text in TEXTS {
        assert_eq!(text.parse::<Filter>().unwrap().to_string(), text);
    }
    let of = |text: &str| text.parse::<Filter>().unwrap();
    assert_eq!(of("pcf2x2"), Filter::Bilinear);
    assert_eq!(of(" pcf : size = 3 px "), Filter::Pcf { size: Extent::pixels(3.0) });
    assert_eq!(of("tent:size=1e1"), Filter::Tent { size: Extent::texels(10.0) });
    assert_eq!(of("poisson:radius=2"), Filter::Poisson { count: 16, radius: Extent::texels(2.0), seed: 0 });
    for size in [1.0, 1.0 / 3.0 + 1.0, 63.999_999_999_999] {
        let filter = Filter::Pcf { size: Extent::texels(size) };
        assert_eq!(of(&filter.to_string()), filter, "all digits");
    }
}

#[test]
fn the_list_has_texts_that_read() {
    for spec in FILTERS {
        let text = if spec.settings.is_empty() { spec.name.into() } else { format!("{}:{}", spec.name, spec.settings) };
        assert_eq!(text.parse::<Filter>().unwrap().to_string(), text);
    }
}

#[test]
fn what_is_wrong_is_named() {
    let cases = [
        ("vsm", "unknown filter \"vsm\": expected one of nearest, bilinear, pcf, tent, poisson"),
        ("", "unknown filter"),
        ("pcf", "filter pcf: size: expected a number of texels, or of pixels with px, got nothing; try size=3"),
        ("pcf:size=", "filter pcf: size: expected a number"),
        ("pcf:size=wide", "got \"wide\""),
        ("pcf:size=nan", "got \"nan\""),
        ("pcf:size=inf", "got \"inf\""),
        ("pcf:size=0.5", "filter pcf: size: expected 1 to 64 texels, got 0.5 texels"),
        ("pcf:size=-3", "got -3 texels"),
        ("pcf:size=65", "got 65 texels"),
        ("pcf:size=0px", "expected more than 0 and at most 64 pixels, got 0 pixels"),
        ("pcf:size=65px", "got 65 pixels"),
        ("pcf:size=3,size=4", "filter pcf: size: expected one value, got two"),
        ("pcf:radius=3", "unknown setting of filter pcf \"radius\": expected one of size"),
        ("nearest:size=3", "filter nearest: expected no settings, got \"size=3\"; write nearest alone"),
        ("pcf2x2:size=3", "filter bilinear: expected no settings"),
        ("tent:size=0", "filter tent: size"),
        ("poisson:count=16", "filter poisson: radius: expected a number of texels"),
        ("poisson:count=0,radius=2", "filter poisson: count: expected 1 to 256 points, got 0"),
        ("poisson:count=257,radius=2", "got 257"),
        ("poisson:count=2.5,radius=2", "filter poisson: count: expected a whole number"),
        ("poisson:seed=-1,radius=2", "filter poisson: seed: expected a whole number"),
        ("poisson:radius=0.4", "expected 0.5 to 32 texels"),
        ("poisson:radius=33", "expected 0.5 to 32 texels"),
    ];
    for (text, message) in cases {
        let error = text.parse::<Filter>().unwrap_err();
        assert!(matches!(error, Error::InvalidArgument { .. } | Error::UnknownName { .. }));
        assert!(error.to_string().contains(message), "{text}: {error}");
        assert!(!error.to_string().contains('\n'));
    }
    // Values that no text makes.
    for length in [f64::NAN, f64::INFINITY, -1.0] {
        assert!(Filter::Pcf { size: Extent::texels(length) }.checked().is_err());
        assert!(Filter::Tent { size: Extent::pixels(length) }.checked().is_err());
    }
}
