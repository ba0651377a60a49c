//! The kinds of notes and their details, each with its name and its text.
//!
//! A place `{name:format}` in a text is a number of the note. Over several maps it becomes a range; a place without a format
//! is exact and part of what the note is about.

/// An enum whose variants have a name for users and a text.
macro_rules! with_texts {
    ($(#[$meta:meta])* $enum:ident { $($(#[doc = $doc:literal])+ $variant:ident $name:literal $text:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $enum { $($(#[doc = $doc])+ $variant,)+ }

        impl $enum {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];
            /// The name that users know.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)+ }
            }
            /// The text, with places for numbers.
            pub(super) fn text(self) -> &'static str {
                match self { $(Self::$variant => $text,)+ }
            }
        }
    };
}

with_texts! {
    /// What a note is about.
    Kind {
        /// The camera sees no part of the scene.
        NothingSeen "nothing_seen" "the camera sees no part of the scene: the map covers what the light can reach",
        /// The camera sees no part of the scene that a placed light reaches.
        NothingLit "nothing_lit"
            "the camera sees no part of the scene that the light reaches: the map covers what the light can reach",
        /// The technique fell back to a uniform map; the details are the reasons.
        NoWarp "no_warp" "no warp, a uniform map: {details}",
        /// A logarithmic map without its logarithm.
        NoLogarithm "no_logarithm" "no logarithm: w hardly varies over what is seen",
        /// The distance from the reference point to the near end: `given` and `least`, world units along the axis.
        WarpDistanceRaised "warp_distance_raised" "warp distance {given:e} raised to {least:e}, the least for the body",
        /// The strength of XPSM: `given` and `most`, per world unit.
        WarpWeakened "warp_weakened"
            "warp weakened from p = {given:.4e} to {most:.4e}, where w comes down to its least",
        /// How far PSM's virtual camera stands back: `given` and `least`; `near` and `far` depth. World units.
        SlideRaised "slide_raised"
            "slide {given:e} raised to {least:e}, the least for depths from {near:e} to {far:e}",
        /// A placed light inside a mesh's box: the `distance` at which its map begins, world units.
        LightInBox "light_in_box"
            "the light is inside a mesh's box: what is nearer to it than {distance:.4} casts no shadow",
        /// A stable map under a placed light.
        Stable "stable" "stable: the map covers all that the light reaches, whatever the camera sees",
        /// `cover=samples` for splits that do not come from samples.
        CoverUnused "cover_unused" "cover has no effect: the splits do not come from samples",
        /// No sample faces the light.
        NoLitSample "no_lit_sample" "no visible surface faces the light: the map is made for all that can be seen",
        /// No sample in shadow.
        NoShadow "no_shadow" "no visible surface is in shadow: the map holds all that faces the light",
        /// `cover=samples`: camera depths `near` to `far`, world units.
        CoversSamples "covers_samples" "the maps cover camera depths {near:.4} to {far:.4} alone: those of the samples",
        /// A given `border` between splits outside of the camera's planes `near` and `far`: camera depths, world units.
        BorderOutside "border_outside"
            "the border {border} is not between the camera's planes ({near} and {far}): a split is empty",
        /// Splits of an orthographic camera, even in depth.
        EvenSplits "even_splits"
            "even splits: an orthographic camera sees all depths at one scale, so no scheme by ratios of depth applies",
        /// A stable map of a camera without an end: `far` is where it ends now, world units.
        EndMoves "end_moves"
            "the far plane is infinite, so the maps end behind the scene, at depth {far:.4}: texels change as the camera moves; give a \
             finite far plane to hold them",
        /// Maps `made` where `count` are asked for: the depths of shadows' edges cannot be divided further.
        FewerMaps "fewer_maps"
            "{made:0} maps of {count:0}: the shadows' edges that are seen do not differ enough in depth for more",
        /// Faces of the camera's frustum without a map; the details are the faces.
        FaceUnseen "face_unseen" "nothing is seen on the way to the {details} face: no map",
        /// A given matrix that is hardly a map of the light; the details are what speaks against it.
        CheckMatrix "check_matrix" "check the matrix: {details}",
    }
}

/// The text of [`Kind::LightInBox`] where it holds for some maps, or not for all of them alike.
pub(super) const LIGHT_IN_SOME_BOX: &str =
    "the light is inside a mesh's box: what is nearer to it than {distance:.4} may cast no shadow";

with_texts! {
    /// What the kind of a note alone does not say.
    Detail {
        /// No warp: the light runs along the axis.
        LightAlongAxis "light_along_axis" "the light runs along the view",
        /// No warp: an orthographic camera has no perspective.
        ParallelRays "parallel_rays" "an orthographic camera sees all depths at one scale, so there is no perspective to follow",
        /// No warp: the body has no extent along the axis.
        FlatBody "flat_body" "what is seen has no extent along the view as the light sees it",
        /// No warp: eye depth does not grow along the axis.
        DepthFallsAlongAxis "depth_falls_along_axis" "eye depth does not grow along the warp axis",
        /// No warp: the line from which the distance is derived begins behind the eye.
        BehindEye "behind_eye" "the near end of what is seen lies behind the eye as the light sees it",
        /// No warp: the `sine` between light and view is below the setting.
        BelowMinSine "below_min_sin" "the sine between light and view, {sine:.3e}, is below min_sin",
        /// No warp: none has less error than a uniform map.
        NoLessError "no_less_error" "no warp distance has less error",
        /// No warp: what lies before the `focus_depth` (world units) has its share of the map without one.
        FocusHasShare "focus_has_share" "the focus depth {focus_depth:.4} has its share without one",
        /// No warp: the `focus_depth` (world units) lies before the body.
        FocusBeforeBody "focus_before_body" "the focus depth {focus_depth:.4} lies before what is seen",
        /// No warp: the virtual camera's w is constant.
        EqualDistances "equal_distances"
            "the virtual camera sees everything from the same distance, as the light does",
        /// No warp: no plane is found, as none of so many `samples` counts.
        NoSample "no_sample" "none of the {samples:0} samples is in this part of the view and faces the light",
        /// No warp: the light lies in the plane.
        LightInPlane "light_in_plane" "the light lies in the plane",
        /// No warp: the plane lies beyond all digits of what is seen.
        PlaneTooFar "plane_too_far" "the plane lies too far from what is seen",
        /// No warp: the eye lies in the plane.
        EyeInPlane "eye_in_plane" "the eye lies in the plane, so the camera sees it as a line",
        /// No warp: light rays meet the plane (`plane_x`, `plane_y`, `plane_z`, `plane_d`; rounded to four places) behind the
        /// eye, at `behind` of so many `corners`.
        RaysBehindEye "rays_behind_eye"
            "light rays through receivers must meet the plane ({plane_x}, {plane_y}, {plane_z}, {plane_d}) before the eye, \
             and do not at {behind:0} of {corners:0} corners of the receivers' body",
        /// No warp: so many of the visible `samples` are `lost` on the plane.
        SamplesLost "samples_lost" "of {samples:0} visible samples {lost:0} are lost",
        /// The face on the left of the frustum.
        Left "left" "left",
        /// The face on the right.
        Right "right" "right",
        /// The face below.
        Bottom "bottom" "bottom",
        /// The face above.
        Top "top" "top",
        /// The near face.
        Near "near" "near",
        /// The far face.
        Far "far" "far",
        /// A matrix's rows do not vanish on the light: the sine `miss` of their angle with rows that do.
        MissesLight "misses_light" "not a map of this light: its rows x, y, w miss the light by {miss:.2g} (0 expected)",
        /// The transpose of the matrix is a map of the light.
        Transposed "transposed" "its transpose is one: give row-major matrices that act on columns",
        /// Depths of a matrix fall along the light.
        DepthFallsAway "depth_falls_away" "depth falls away from the light: reversed z?",
        /// The `share` of the visible surface, in per cent, with depths between -1 and 0.
        DepthBelowZero "depth_below_zero"
            "{share:.2g} % of the visible surface has depths between -1 and 0: z in -1..1?",
        /// A matrix's map holds nothing that is seen.
        NothingInMap "nothing_in_map" "no visible surface lies in the map",
    }
}

impl Kind {
    /// The kind of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }
    /// What stands between the texts of several details.
    pub(super) fn between_details(self) -> &'static str {
        if self == Self::FaceUnseen { " or the " } else { "; " }
    }
}

impl Detail {
    /// The detail of a kind by its name.
    pub fn named(kind: Kind, name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|detail| detail.kind() == kind && detail.name() == name)
    }
    /// The kind that it belongs to.
    pub fn kind(self) -> Kind {
        match self {
            Self::Left | Self::Right | Self::Bottom | Self::Top | Self::Near | Self::Far => Kind::FaceUnseen,
            Self::MissesLight | Self::Transposed | Self::DepthFallsAway | Self::DepthBelowZero | Self::NothingInMap => {
                Kind::CheckMatrix
            }
            _ => Kind::NoWarp,
        }
    }
}
