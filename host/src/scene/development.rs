//! How the light of a scene becomes the colours of a picture.

/// How the light of a scene becomes the colours of a picture: exposure, tone curve and what is
/// behind the objects. The background keeps its colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub struct Development {
    /// Stops: each doubles the light.
    pub exposure: f64,
    /// The tone curve.
    pub tone: Tone,
    /// Whether the background is transparent.
    pub is_transparent: bool,
}

/// Curve from light to the colours of a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "transfer", derive(serde::Deserialize, serde::Serialize))]
pub enum Tone {
    /// Light beyond 1 is cut off.
    #[default]
    Clip,
    /// AgX by Troy Sobotka, as in Blender, three.js and Filament: bright light fades to white.
    Agx,
}

impl Tone {
    /// All of them.
    pub const ALL: [Tone; 2] = [Tone::Clip, Tone::Agx];

    /// Returns the name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Tone::Clip => "clip",
            Tone::Agx => "agx",
        }
    }
}
