//! Masks of several maps against traced truth: along the seams between maps as elsewhere.

use shadowlab::Progress;
use shadowlab::image::{ShadowMask, TruthMask};
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::trace::Tracer;

use crate::render::selection::maps::{SAME, View, views};

const SIZE: [u32; 2] = [320, 200];
const RESOLUTION: u32 = 2048;

/// Most wrong pixels of those compared; the worst view has 0.022.
const WRONG_SHARE: f64 = 0.025;
/// Most wrong pixels at seams, as a multiple of the share elsewhere, and beside that. Seams by depth run along outlines of
/// things, where edges of shadows are dense: between equal maps, which have no seam of their own, the multiple is up to 1.4; a
/// few hundred pixels with a share of 1 % have a spread of as much again.
const SEAM_TIMES: f64 = 2.0;
const SEAM_SHARE: f64 = 5e-3;
/// Most wrong pixels of four maps, as a multiple of those of one as large: each has a quarter of the view or so. The worst
/// view has 0.52.
const FOUR_TIMES: f64 = 0.7;

/// Pixels compared, and wrong.
#[derive(Debug, Default, Clone, Copy)]
struct Count {
    compared: usize,
    wrong: usize,
}

impl Count {
    fn share(self) -> f64 {
        self.wrong as f64 / self.compared.max(1) as f64
    }
}

/// What is found in a view.
#[derive(Debug, Default)]
pub struct Found {
    /// Within a pixel of another map.
    seam: Count,
    elsewhere: Count,
    /// Wrong under one map for the whole view, at the pixels of the seams.
    seam_under_whole: Option<usize>,
    /// Pixels that face the light and that no map holds.
    unheld: usize,
}

impl Found {
    /// The mask of a renderer against truth.
    pub fn new(renderer: &dyn Renderer, v: &View, truth: &[i8]) -> Self {
        let settings = MaskSettings {
            resolution: [RESOLUTION; 2],
            size: SIZE,
            bias: Bias::default(),
            filter: Filter::Nearest,
            blend: 0.0,
            stored: Stored::default(),
        };
        let mask = |p| renderer.shadow_mask(&v.scene, &v.camera, &v.light, p, &settings, &Progress::new()).unwrap();
        let m = mask(&v.p);
        let whole = v.whole.as_ref().map(mask);
        let mut found = Self { seam_under_whole: whole.as_ref().map(|_| 0), ..Self::default() };
        for (i, &truth) in truth.iter().enumerate() {
            let lit = match truth {
                TruthMask::LIT => true,
                TruthMask::SHADOW => false,
                _ => continue,
            };
            if m.data[i].is_nan() {
                continue;
            }
            // No map, yet not dark as what faces away is.
            found.unheld += usize::from(m.partition[i] == ShadowMask::NO_MAP && m.data[i] > 0.0);
            let is_seam = is_seam(&m, i);
            if let (true, Some(whole), Some(wrong)) = (is_seam, &whole, &mut found.seam_under_whole) {
                *wrong += usize::from((whole.data[i] >= 0.5) != lit);
            }
            let count = if is_seam { &mut found.seam } else { &mut found.elsewhere };
            count.compared += 1;
            count.wrong += usize::from((m.data[i] >= 0.5) != lit);
        }
        found
    }

    /// Panics unless seams are as good as the rest, and every pixel has its map.
    pub fn assert_small(&self, what: &str) {
        assert!(self.seam.compared > 50, "{what}: no seam to see");
        assert_eq!(self.unheld, 0, "{what}: pixels in no map");
        assert!(self.elsewhere.share() <= WRONG_SHARE, "{what}: {self:?}");
        let is_as_elsewhere = self.seam.share() <= SEAM_TIMES * self.elsewhere.share() + SEAM_SHARE;
        // Or the very same pixels are hard: one map without seams has as many wrong there.
        let is_as_whole = self.seam_under_whole.is_some_and(|wrong| self.seam.wrong <= wrong);
        assert!(is_as_elsewhere || is_as_whole, "{what}: {self:?}");
    }

    fn wrong(&self) -> usize {
        self.seam.wrong + self.elsewhere.wrong
    }
}

/// Whether a neighbour asks another map.
fn is_seam(m: &ShadowMask, i: usize) -> bool {
    let [width, height] = SIZE.map(|n| n as usize);
    let (x, y) = (i % width, i / width);
    let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
    let around = rows.flat_map(|y| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |x| y * width + x));
    // Where the surface turns away from the light there is no map, and no seam between two.
    let mut asked = around.map(|j| m.partition[j]).filter(|&k| k >= 0);
    m.partition[i] >= 0 && asked.any(|k| k != m.partition[i])
}

/// What rays say of a view.
pub fn truth(v: &View) -> Vec<i8> {
    let tracer = Tracer::new(&v.scene, &Progress::new()).unwrap();
    tracer.shadow_mask(&v.camera, &v.light, SIZE, &Progress::new()).unwrap().data
}

/// Holds all views.
pub fn assert_seams_hold(renderer: &dyn Renderer) {
    let mut known: Option<(String, Vec<i8>)> = None;
    let (mut of_four, mut of_one) = (vec![], vec![]);
    for v in views() {
        let key = format!("{}, {:?}", v.scene.id(), v.light);
        if known.as_ref().is_none_or(|(k, _)| *k != key) {
            known = Some((key.clone(), truth(&v)));
        }
        let found = Found::new(renderer, &v, &known.as_ref().expect("just traced").1);
        println!("{}, {}: {found:?}", renderer.backend(), v.name);
        found.assert_small(&v.name);
        if v.name.ends_with("four of lispsm") {
            of_four.push(found.wrong());
        } else if v.name.ends_with(SAME) {
            of_one.push(found.wrong());
        }
    }
    assert!(of_one.len() == of_four.len() && !of_one.is_empty());
    for (four, one) in of_four.into_iter().zip(of_one) {
        assert!(four as f64 <= FOUR_TIMES * one as f64, "four maps: {four} wrong, one: {one}");
    }
}
