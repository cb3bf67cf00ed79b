//! Which method rebuilds a picture.

stack::knob_choice! {
    /// A method of reconstruction.
    pub enum Method {
        /// This project's: what `fit` says.
        Ours = "ours",
        /// None: the mean of the samples, with its variance as error.
        Ld = "ld",
        /// Weighted local regression (Moon, Carr, Yoon 2014).
        Wlr = "wlr",
        /// The same with the pilot bandwidth of the paper (its figure 2).
        Wlrp = "wlrp",
        /// The same with visibility among its features (the paper's figure 3).
        Wlrv = "wlrv",
        /// Nonlinearly weighted first-order regression (Bitterli et al. 2016).
        Nfor = "nfor",
        /// Adaptive polynomial rendering (Moon et al. 2016).
        Apr = "apr",
        /// The learning-based filter (Kalantari et al. 2015).
        Lbf = "lbf",
    }
}

stack::knob_choice! {
    /// How the method `ours` rebuilds a picture.
    pub enum Fit {
        /// The paper's: spikes replaced, features propagated and reduced, one local linear fit at every pixel.
        Local = "local",
        /// Two passes of collaborative fits on all features, light split into a low layer and events.
        Collaborative = "collaborative",
    }
}

stack::knobs! {
    /// Which method rebuilds the picture.
    pub struct MethodSettings("") {
        /// Reconstruction method: ours, or one to compare it with.
        method: Method = Method::Ours, ..;
        /// How ours rebuilds: local is the paper's regression at every pixel, collaborative two passes of fits that
        /// predict their whole window.
        fit: Fit = Fit::Collaborative, ..;
    }
}

impl MethodSettings {
    /// Whether it is ours by collaborative fits: what the presets `best` and `fast` are.
    pub fn is_collaborative(&self) -> bool {
        self.method == Method::Ours && self.fit == Fit::Collaborative
    }
}
