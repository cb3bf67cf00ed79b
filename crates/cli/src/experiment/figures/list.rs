//! Figures 1 to 9: what they compare and what is measured.

use super::figure::Figure;
use super::layers::{BANDWIDTH_MAP, ERROR_MAP, RANK_MAP, SPIKES, VISIBILITY};
use super::measures::{
    BANDWIDTH_HIGH, BANDWIDTH_LOW, BANDWIDTH_MEDIAN, BANDWIDTH_SECONDS, CURVATURE_SECONDS, ENERGY, ERROR, MARKED,
    PREFILTER_SECONDS, RANK, REDUCE_SECONDS, REGRESSION_SECONDS, SECONDS, SIGNAL, SPIKE_SECONDS, SSIM, SURFACES_ERROR,
    TOO_BRIGHT, TRIMMED, VISIBILITY_ERROR,
};
use crate::experiment::case::Entry;
use crate::settings::Preset::Paper;

const OURS: Entry = ("ours", Paper, &[]);
const WLR: Entry = ("wlr", Paper, &[("method", "wlr")]);

/// All of them.
pub const FIGURES: &[Figure] = &[
    Figure {
        numbers: &[1],
        about: "what is taken for spikes",
        entries: &[
            ("none", Paper, &[("spike-removal", "false")]),
            ("lbf", Paper, &[("spike-method", "lbf")]),
            OURS,
            ("ours relative", Paper, &[("spike-threshold-unit", "log-average")]),
        ],
        measures: &[&MARKED, &SIGNAL, &ERROR, &TRIMMED, &SSIM, &ENERGY],
        layers: &[&SPIKES],
    },
    Figure {
        numbers: &[2],
        about: "pilot bandwidth inside WLR",
        entries: &[WLR, ("wlrp", Paper, &[("method", "wlrp")])],
        measures: &[&ERROR, &TRIMMED, &SSIM, &ENERGY, &SECONDS],
        layers: &[&BANDWIDTH_MAP],
    },
    Figure {
        numbers: &[3],
        about: "visibility as a feature",
        entries: &[
            WLR,
            ("wlrv", Paper, &[("method", "wlrv")]),
            ("ours without", Paper, &[("prefilter-visibility", "false")]),
            OURS,
        ],
        measures: &[&ERROR, &TRIMMED, &SSIM, &ENERGY],
        layers: &[],
    },
    Figure {
        numbers: &[4],
        about: "the steps, and their seconds",
        entries: &[OURS],
        measures: &[
            &SPIKE_SECONDS,
            &PREFILTER_SECONDS,
            &REDUCE_SECONDS,
            &BANDWIDTH_SECONDS,
            &CURVATURE_SECONDS,
            &REGRESSION_SECONDS,
            &SECONDS,
        ],
        layers: &[&SPIKES, &VISIBILITY, &RANK_MAP, &BANDWIDTH_MAP, &ERROR_MAP],
    },
    Figure {
        numbers: &[5],
        about: "spikes left in the result",
        entries: &[("none", Paper, &[("spike-removal", "false")]), WLR, OURS],
        measures: &[&TOO_BRIGHT, &ERROR, &TRIMMED, &ENERGY],
        layers: &[&SPIKES],
    },
    Figure {
        numbers: &[6, 7],
        about: "prefilters of the features",
        entries: &[
            ("off", Paper, &[("prefilter-filter", "off")]),
            ("pixel", Paper, &[("prefilter-filter", "pixel")]),
            ("patch", Paper, &[]),
            ("nl-means", Paper, &[("prefilter-filter", "nl-means")]),
        ],
        measures: &[&VISIBILITY_ERROR, &SURFACES_ERROR, &ERROR, &TRIMMED, &SSIM, &PREFILTER_SECONDS],
        layers: &[&VISIBILITY],
    },
    Figure {
        numbers: &[8],
        about: "how many directions are kept",
        entries: &[
            ("k2", Paper, &[("reduce-rank", "perturbation")]),
            ("k1", Paper, &[("reduce-rank", "energy")]),
            ("max", Paper, &[]),
            ("svd", Paper, &[("reduce-method", "svd")]),
        ],
        measures: &[&RANK, &ERROR, &TRIMMED, &SSIM],
        layers: &[&RANK_MAP],
    },
    Figure {
        numbers: &[9],
        about: "shared bandwidth",
        entries: &[WLR, OURS],
        measures: &[
            &BANDWIDTH_LOW,
            &BANDWIDTH_MEDIAN,
            &BANDWIDTH_HIGH,
            &REDUCE_SECONDS,
            &BANDWIDTH_SECONDS,
            &SECONDS,
            &ERROR,
        ],
        layers: &[&BANDWIDTH_MAP],
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::case::settings;

    #[test]
    fn every_entry_is_a_setting_of_its_own() {
        for figure in FIGURES {
            let all: Vec<_> =
                figure.entries.iter().map(|(_, preset, flags)| settings(*preset, flags).unwrap()).collect();
            for (i, one) in all.iter().enumerate() {
                assert!(!all[..i].contains(one), "figure {:?}: entry {i} repeats another", figure.numbers);
            }
        }
        let numbers: Vec<u32> = FIGURES.iter().flat_map(|figure| figure.numbers).copied().collect();
        assert_eq!(numbers, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
    }
}
