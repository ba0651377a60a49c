//! Alpha tests: objects with the fields of `shadowlab.AlphaTest` become those of the core, and the way back.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Weak};

use arc_swap::ArcSwap;
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;

use super::convert::{OrRaise, argument_error, array, image, number, shown};
use crate::digest::{Digest, Numbers};
use crate::error::Result;
use crate::scene::{AlphaTest, AlphaTestParts, AlphaTexture, Wrap};

/// Names of [`Wrap::ALL`].
const WRAPS: [&str; 3] = ["repeat", "mirror", "clamp"];

/// Textures in use by their content. No lock, so that a process that is forked meanwhile has none that nobody gives back.
static KNOWN: LazyLock<ArcSwap<HashMap<[u8; 32], Weak<AlphaTexture>>>> = LazyLock::new(Default::default);

/// The texture of these texels: one for all meshes that have the same.
pub fn shared_texture(size: [u32; 2], texels: Vec<u8>) -> Result<Arc<AlphaTexture>> {
    let mut digest = Digest::new("shadowlab alpha texture", Numbers::Exact);
    digest.list(&size);
    digest.list(&texels);
    let key = digest.finish();
    if let Some(known) = KNOWN.load().get(&key).and_then(Weak::upgrade) {
        return Ok(known);
    }
    let made = Arc::new(AlphaTexture::new(size, texels)?);
    KNOWN.rcu(|known| {
        let mut known = HashMap::clone(known);
        known.retain(|_, texture| texture.strong_count() > 0);
        known.insert(key, Arc::downgrade(&made));
        known
    });
    Ok(made)
}

/// The test of an object with the fields of `shadowlab.AlphaTest`.
pub fn alpha_test(value: &Bound<'_, PyAny>) -> PyResult<AlphaTest> {
    let py = value.py();
    let fix = "make one with shadowlab.AlphaTest";
    let field = |name: &str| {
        let found = value.getattr(name);
        found.map_err(|_| argument_error(py, "alpha", "an AlphaTest, or None", shown(value), fix))
    };
    let (texture, uv, wrap) = (field("texture")?, field("uv")?, field("wrap")?);
    let (cutoff, factor) = (field("cutoff")?, field("factor")?);
    let cutoff = number(&cutoff, "alpha.cutoff", "0.5 is usual")?;
    let factor = number(&factor, "alpha.factor", "1 changes nothing")?;
    let names = wrap.extract::<[String; 2]>().ok();
    let wrap = names.and_then(|names| {
        let [u, v] = names.map(|name| WRAPS.iter().position(|known| *known == name));
        Some([Wrap::ALL[u?], Wrap::ALL[v?]])
    });
    let Some(wrap) = wrap else {
        let expected = format!("two of {}", WRAPS.map(|name| format!("{name:?}")).join(", "));
        return Err(argument_error(py, "alpha.wrap", expected, shown(&field("wrap")?), "name one for u and one for v"));
    };
    let uv = array::<f32>(&uv, "alpha.uv", &[None, Some(2)])?;
    let uv = uv.as_slice()?;
    let texture = if texture.is_none() { None } else { Some(array::<u8>(&texture, "alpha.texture", &[None, None])?) };
    let texels = match &texture {
        Some(texture) => Some((texture.shape(), texture.as_slice()?)),
        None => None,
    };
    let made = py.detach(|| {
        let texture = match texels {
            Some((shape, texels)) => Some(shared_texture([shape[1] as u32, shape[0] as u32], texels.to_vec())?),
            None => None,
        };
        AlphaTest::new(AlphaTestParts { texture, uv: uv.as_chunks::<2>().0.to_vec(), cutoff, wrap, factor })
    });
    made.or_raise(py)
}

/// The `shadowlab.AlphaTest` of a test.
pub fn alpha_test_object<'py>(py: Python<'py>, test: &AlphaTest) -> PyResult<Bound<'py, PyAny>> {
    let AlphaTestParts { texture, uv, cutoff, wrap, factor } = test.parts();
    let texture = match texture {
        None => None,
        Some(texture) => {
            let [width, height] = texture.size().map(|n| n as usize);
            Some(image(py, texture.texels().to_vec(), [height, width])?)
        }
    };
    let uv = image(py, uv.as_flattened().to_vec(), [uv.len(), 2])?;
    let wrap = wrap.map(|wrap| WRAPS[wrap as usize]);
    let class = py.import("shadowlab.scene.alpha_test")?.getattr("AlphaTest")?;
    class.call1((texture, uv, *cutoff, (wrap[0], wrap[1]), *factor))
}
