//! Simulated floors and links.

use crate::checked::Checked;
use crate::training::{
    Floor, LatePackets, Link, LinkModel, Outage, Rtt, Silences, Slip, SlipChannel, Spec, TraceRow,
};
use umwelt_core::link::{self, PRESETS};
use umwelt_core::plant::{self, SLIP_PRESETS, SlipError};

impl From<plant::SlipChannel> for SlipChannel {
    fn from(core: plant::SlipChannel) -> Self {
        Self { mean: core.mean(), sd: core.sd() }
    }
}

impl SlipChannel {
    fn convert(self) -> Result<plant::SlipChannel, SlipError> {
        plant::SlipChannel::new(self.mean, self.sd)
    }
}

impl Slip {
    /// The slip in core's terms, whatever its ranges: what a program keeps was checked when it came.
    ///
    /// # Errors
    /// Where a channel is no slip at all.
    pub fn convert(self) -> Result<plant::Slip, SlipError> {
        Ok(plant::Slip {
            forward: self.forward.convert()?,
            lateral: self.lateral.convert()?,
            turn: self.turn.convert()?,
            drift: self.drift.convert()?,
        })
    }
}

impl From<plant::Slip> for Slip {
    fn from(core: plant::Slip) -> Self {
        Self {
            forward: core.forward.into(),
            lateral: core.lateral.into(),
            turn: core.turn.into(),
            drift: core.drift.into(),
        }
    }
}

impl From<plant::Slip> for Floor {
    /// By its name where it is a preset.
    fn from(core: plant::Slip) -> Self {
        let preset = SLIP_PRESETS.into_iter().find(|name| plant::Slip::preset(name) == Some(core));
        preset.map_or_else(|| Self::Slip(core.into()), |name| Self::Preset(name.to_owned()))
    }
}

impl From<&link::Rtt> for Rtt {
    fn from(core: &link::Rtt) -> Self {
        match core {
            link::Rtt::Constant(rtt) => Self::Constant { rtt_s: *rtt },
            link::Rtt::Lognormal { median, p99 } => {
                Self::Lognormal { median_s: *median, p99_s: *p99 }
            }
            link::Rtt::Trace(trace) => {
                let rows = trace.rows().iter();
                Self::Trace { rows: rows.map(|&(t_s, rtt_s)| TraceRow { t_s, rtt_s }).collect() }
            }
        }
    }
}

impl Rtt {
    fn convert(&self) -> Result<link::Rtt, link::TraceError> {
        Ok(match self {
            Self::Constant { rtt_s } => link::Rtt::Constant(*rtt_s),
            Self::Lognormal { median_s, p99_s } => {
                link::Rtt::Lognormal { median: *median_s, p99: *p99_s }
            }
            Self::Trace { rows } => {
                let rows = rows.iter().map(|row| (row.t_s, row.rtt_s)).collect();
                link::Rtt::Trace(link::RttTrace::new(rows)?)
            }
        })
    }
}

impl From<link::LatePackets> for LatePackets {
    fn from(core: link::LatePackets) -> Self {
        let after_late = Some(core.after_late);
        Self { probability: core.probability, after_late, extra_s: core.extra }
    }
}

impl LatePackets {
    fn convert(self) -> link::LatePackets {
        let after_late = self.after_late.unwrap_or(self.probability);
        link::LatePackets { probability: self.probability, after_late, extra: self.extra_s }
    }
}

impl From<link::Silences> for Silences {
    fn from(core: link::Silences) -> Self {
        Self { rate_per_s: core.rate, shortest_s: core.shortest, longest_s: core.longest }
    }
}

impl Silences {
    fn convert(self) -> link::Silences {
        link::Silences { rate: self.rate_per_s, shortest: self.shortest_s, longest: self.longest_s }
    }
}

impl LinkModel {
    /// The link in core's terms, whatever its ranges: what a program keeps was checked when it came.
    ///
    /// # Errors
    /// Where a recording is none at all.
    pub fn convert(&self) -> Result<link::LinkModel, link::TraceError> {
        let outages = self.outages.iter();
        Ok(link::LinkModel {
            sensor_delay: self.sensor_delay_s,
            rtt: self.rtt.convert()?,
            late: self.late.convert(),
            outages: outages
                .map(|it| link::Outage { start: it.start_s, duration: it.duration_s })
                .collect(),
            silences: self.silences.convert(),
            in_order: self.in_order,
        })
    }
}

impl From<&link::LinkModel> for LinkModel {
    fn from(core: &link::LinkModel) -> Self {
        let outages = core.outages.iter();
        Self {
            sensor_delay_s: core.sensor_delay,
            rtt: (&core.rtt).into(),
            late: core.late.into(),
            outages: outages
                .map(|it| Outage { start_s: it.start, duration_s: it.duration })
                .collect(),
            silences: core.silences.into(),
            in_order: core.in_order,
        }
    }
}

impl From<&link::LinkModel> for Link {
    /// By its name where it is a preset.
    fn from(core: &link::LinkModel) -> Self {
        let same = |name: &&str| link::LinkModel::preset(name).as_ref() == Some(core);
        match PRESETS.into_iter().find(same) {
            Some(name) => Self::Preset(name.to_owned()),
            None => Self::Model(Box::new(core.into())),
        }
    }
}

impl Checked<Spec> {
    /// The floor in core's terms.
    pub fn to_slip(&self) -> plant::Slip {
        match &self.slip {
            Floor::Preset(name) => plant::Slip::preset(name).expect("the name of a floor"),
            Floor::Slip(slip) => slip.convert().expect("numbers in their ranges are a slip"),
        }
    }

    /// The link in core's terms.
    pub fn to_link(&self) -> link::LinkModel {
        match &self.link {
            Link::Preset(name) => link::LinkModel::preset(name).expect("the name of a link"),
            Link::Model(model) => model.convert().expect("checked rows are a recording"),
        }
    }
}
