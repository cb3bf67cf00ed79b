//! Passes: layers of light that are carried along and may be rebuilt with the picture.

use exr::prelude::{FlatSamples, f16};

use super::layer_list::{LayerNames, layers_of, normalise};
use super::mend::make_finite;
use crate::{Fault, FeatureStack, Image};

/// A layer of three channels among those that a stack carries along.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Its full name.
    pub name: String,
    channels: [usize; 3],
}

/// A pass that was asked for cannot be found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PassError {
    /// There is none of that name.
    #[error("no pass is called '{name}': {}", expected(passes))]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        passes: Vec<String>,
    },
    /// There are several.
    #[error("'{name}' may be each of {}: give the full name", passes.join(", "))]
    Ambiguous {
        /// What was asked for.
        name: String,
        /// What it may be.
        passes: Vec<String>,
    },
}

fn expected(names: &[String]) -> String {
    if names.is_empty() {
        return "no layer of colours is carried along".into();
    }
    format!("expected one of {}", names.join(", "))
}

impl PassError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        Fault::Input
    }
}

impl Pass {
    /// The pass of `stack` called `name`: its full name, or what stands behind the last dot, whatever its case.
    ///
    /// # Errors
    /// When there is none, or several.
    pub fn find(stack: &FeatureStack, name: &str) -> Result<Self, PassError> {
        let layers = layers_of(stack.passthrough.iter().map(|channel| channel.name.as_str()));
        let of_layer = |layer: LayerNames| {
            let channels = colours(stack, &layer)?;
            Some((layer.key, Self { name: layer.name, channels }))
        };
        let passes: Vec<(String, Self)> = layers.into_iter().filter_map(of_layer).collect();
        if let Some((_, whole)) = passes.iter().find(|(_, pass)| pass.name == name) {
            return Ok(whole.clone());
        }
        let alike: Vec<&Self> =
            passes.iter().filter(|(key, _)| *key == normalise(name)).map(|(_, pass)| pass).collect();
        let name = name.to_string();
        match alike[..] {
            [one] => Ok(one.clone()),
            [] => Err(PassError::Unknown { name, passes: passes.into_iter().map(|(_, pass)| pass.name).collect() }),
            _ => Err(PassError::Ambiguous { name, passes: alike.iter().map(|pass| pass.name.clone()).collect() }),
        }
    }

    /// Its values, and how many of them were no finite numbers: a single one would spoil all that is rebuilt around it, so
    /// they are mended as those of the picture are.
    ///
    /// # Panics
    /// When `stack` is not the one it was found in.
    pub fn image(&self, stack: &FeatureStack) -> (Image, usize) {
        let plane = |channel: usize| {
            let channel = &stack.passthrough[channel];
            (0..stack.size().pixels()).map(|pixel| channel.value(pixel)).collect()
        };
        let mut image = Image::from_channels(stack.size(), self.channels.map(plane).into());
        let mended = make_finite(&mut image);
        (image, mended)
    }

    /// Puts `image` in its place, as the type of number that was there; what is too large for half precision becomes the
    /// largest half, and not infinite.
    ///
    /// # Panics
    /// As [`Self::image`].
    pub fn replace(&self, stack: &mut FeatureStack, image: Image) {
        for (channel, plane) in self.channels.iter().zip(image.into_channels()) {
            let samples = &mut stack.passthrough[*channel].samples;
            *samples = match samples {
                FlatSamples::F16(_) => FlatSamples::F16(plane.into_iter().map(nearest_half).collect()),
                _ => FlatSamples::F32(plane),
            };
        }
    }
}

/// The half that is nearest to `value`, infinite only if that is.
fn nearest_half(value: f32) -> f16 {
    let most = f16::MAX.to_f32();
    f16::from_f32(if value.is_finite() { value.clamp(-most, most) } else { value })
}

/// Where the colours of a layer are, when it has them as floating-point numbers.
fn colours(stack: &FeatureStack, layer: &LayerNames) -> Option<[usize; 3]> {
    let place = |suffix: &str| {
        let name = layer.channel(suffix)?;
        let at = stack.passthrough.iter().position(|channel| channel.name == name)?;
        (!matches!(stack.passthrough[at].samples, FlatSamples::U32(_))).then_some(at)
    };
    Some([place("R")?, place("G")?, place("B")?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::Passthrough;
    use crate::{SampleCounts, Size, Window};

    fn stack() -> FeatureStack {
        let size = Size::new(2, 1);
        let half = |v: f32| FlatSamples::F16(vec![f16::from_f32(v); 2]);
        let mut passthrough = Vec::new();
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            let mut push =
                |layer: &str, samples| passthrough.push(Passthrough { name: format!("{layer}.{name}"), samples });
            push("View.DiffDir", half(c as f32));
            push("View.Group", FlatSamples::F32(vec![2.0; 2]));
            push("Other.Group", FlatSamples::F32(vec![3.0; 2]));
            push("View.Crypto", FlatSamples::U32(vec![7; 2]));
        }
        FeatureStack {
            window: Window::whole(size),
            film: size,
            samples: SampleCounts::uniform(2, vec![1]),
            components: Vec::new(),
            indirect: None,
            gathered: None,
            features: Vec::new(),
            passthrough,
        }
    }

    #[test]
    fn what_is_no_number_is_the_median_around_it() {
        let mut stack = stack();
        let group = Pass::find(&stack, "Other.Group").unwrap();
        let (green, blue) = (group.channels[1], group.channels[2]);
        stack.passthrough[green].samples = FlatSamples::F32(vec![f32::NAN, 3.0]);
        stack.passthrough[blue].samples = FlatSamples::F32(vec![f32::INFINITY; 2]);
        let (image, mended) = group.image(&stack);
        assert_eq!((image.rgb(0), image.rgb(1), mended), ([3.0, 3.0, 0.0], [3.0, 3.0, 0.0], 3));
    }

    #[test]
    fn passes_are_found_by_their_names_and_keep_their_numbers() {
        let mut stack = stack();
        let pass = Pass::find(&stack, "diffdir").unwrap();
        assert_eq!((pass.name.as_str(), pass.image(&stack).0.rgb(1)), ("View.DiffDir", [0.0, 1.0, 2.0]));
        pass.replace(&mut stack, Image::from_channels(Size::new(2, 1), vec![vec![0.5; 2]; 3]));
        assert_eq!(pass.image(&stack).0.rgb(0), [0.5; 3]);
        assert!(matches!(stack.passthrough[0].samples, FlatSamples::F16(_)));
        pass.replace(&mut stack, Image::from_channels(Size::new(2, 1), vec![vec![7e4, -1e30]; 3]));
        assert_eq!([0, 1].map(|pixel| pass.image(&stack).0.rgb(pixel)[0]), [65504.0, -65504.0]);
        assert_eq!(Pass::find(&stack, "Other.Group").unwrap().image(&stack).0.rgb(0), [3.0; 3]);
    }

    #[test]
    fn what_is_not_there_or_not_clear_is_an_error_that_lists_what_is() {
        let told = |name| Pass::find(&stack(), name).unwrap_err().to_string();
        assert_eq!(told("group"), "'group' may be each of View.Group, Other.Group: give the full name");
        let all = "View.DiffDir, View.Group, Other.Group";
        assert_eq!(told("crypto"), format!("no pass is called 'crypto': expected one of {all}"));
    }
}
