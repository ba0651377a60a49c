//! The instances that one pass draws, found by a walk over the scene's hierarchy.

use rayon::prelude::*;

use super::asked::Asked;
use super::rule::Rule;
use super::volume::Volume;
use crate::geometry::Aabb;
use crate::scene::{Enter, Scene};

/// Which instances a pass draws.
#[derive(Debug, Clone, Copy)]
pub enum Keep<'a> {
    /// All.
    All,
    /// Those that may lie in its volume.
    InVolume,
    /// Of these, those that may change what is looked up.
    Asked(&'a Asked),
}

impl Keep<'_> {
    /// The instances that are drawn into a volume.
    pub fn instances(&self, scene: &Scene, volume: &Volume) -> Vec<u32> {
        if matches!(self, Self::All) {
            return (0..scene.instances().len() as u32).collect();
        }
        let enter = |bounds: &Aabb| match self.rule_of_group(volume, bounds) {
            None => Enter::Each,
            Some(Rule::Drawn) => Enter::All,
            Some(_) => Enter::No,
        };
        scene.tree().select(enter, |i| self.rule_of(scene, volume, i) == Rule::Drawn)
    }

    /// What becomes of each instance.
    pub fn rules(&self, scene: &Scene, volume: &Volume) -> Vec<Rule> {
        if matches!(self, Self::All) {
            return vec![Rule::Drawn; scene.instances().len()];
        }
        let tree = scene.tree();
        let mut rules = tree.classify(|bounds| self.rule_of_group(volume, bounds), |i| self.rule_of(scene, volume, i));
        // A group that changes nothing may lie across the border of the volume.
        rules.par_iter_mut().enumerate().for_each(|(i, rule)| {
            let is_culled = matches!(rule, Rule::Unseen | Rule::Behind);
            if is_culled && Keep::InVolume.rule_of(scene, volume, i) == Rule::Outside {
                *rule = Rule::Outside;
            }
        });
        rules
    }

    /// What becomes of all instances in a box; nothing where that is to be asked of each.
    fn rule_of_group(&self, volume: &Volume, bounds: &Aabb) -> Option<Rule> {
        match (volume.enter(bounds), self) {
            (Enter::No, _) => Some(Rule::Outside),
            (_, Self::Asked(asked)) => asked.rule_against(&bounds.corners()),
            (Enter::All, _) => Some(Rule::Drawn),
            (Enter::Each, _) => None,
        }
    }

    /// What becomes of an instance.
    fn rule_of(&self, scene: &Scene, volume: &Volume, instance: usize) -> Rule {
        let bounds = scene.mesh_of(instance).bounds_local();
        if !volume.may_hold(&scene.clip_from_local(volume.clip_from_world(), instance), bounds) {
            return Rule::Outside;
        }
        let Self::Asked(asked) = self else { return Rule::Drawn };
        let placed = scene.box_of(instance, glam::DVec3::ZERO);
        asked.rule_against(&placed.corners()).unwrap_or(Rule::Drawn)
    }
}
