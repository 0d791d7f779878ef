//! The stages of a made clip: make and judge, with parents kept as long as the next recipes need them.

use super::settings::RunSettings;
use super::work::{ClipOrigin, Out, Outcome, RecipeJob, Work};
use crate::corpus::{Catalog, CorpusError};
use crate::motion::{Notice, Severity};
use crate::synthesis::judge::{Figures, Reference, Verdict, figure_rows, judge};
use crate::synthesis::making::make;
use crate::synthesis::{GraftedClip, Made, Movement, Rule, Subject};
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;
use std::sync::Arc;

/// Parents kept: recipes come sorted by base, so a base serves its row of donors.
const PARENTS_KEPT: usize = 12;

struct Parent {
    clip_id: u32,
    subject: Subject,
    header: String,
    roles: crate::motion::RoleMap,
    /// At its own rate; other rates are judged when they are met.
    figures: Figures,
}

/// Makes and judges the recipes of one worker.
pub(super) struct Maker {
    catalog: Option<Catalog>,
    settings: Arc<RunSettings>,
    reference: Arc<Reference>,
    parents: VecDeque<Rc<Parent>>,
    /// Made and not yet judged, by clip_id: two clips may be on their way.
    unjudged: BTreeMap<u32, (Rc<Parent>, Rc<Parent>, GraftedClip)>,
}

impl Maker {
    pub(super) fn new(catalog: Option<Catalog>, settings: Arc<RunSettings>, reference: Arc<Reference>) -> Maker {
        Maker { catalog, settings, reference, parents: VecDeque::new(), unjudged: BTreeMap::new() }
    }

    /// Makes the clip of a recipe; clips from files pass.
    pub(super) fn make(&mut self, work: &mut Work) -> Result<(), Out> {
        let ClipOrigin::Recipe(job) = work.job().origin.clone() else { return Ok(()) };
        let base = self.parent(job.base)?;
        let donor = self.parent(job.donor)?;
        let settings = Arc::clone(&self.settings);
        let grafted = make(&job.recipe, &base.subject, &donor.subject, &settings.action, &settings.graft)
            .map_err(|refusal| rejected(&job, vec![refusal.name().to_owned()]))?;
        work.clip = Some(Arc::new(grafted.clip.clone()));
        work.roles = base.roles.clone();
        work.facts.header = base.header.clone();
        self.unjudged.insert(work.job().clip_id, (base, donor, grafted));
        Ok(())
    }

    /// Judges the clip that was just made; clips from files pass.
    pub(super) fn judge(&mut self, work: &mut Work) -> Result<(), Out> {
        let ClipOrigin::Recipe(job) = work.job().origin.clone() else { return Ok(()) };
        let Some((base, donor, grafted)) = self.unjudged.remove(&work.job().clip_id) else { return Ok(()) };
        let own =
            Movement::of_clip(&grafted.clip, &base.roles).map_err(|unfit| rejected(&job, vec![unfit.to_string()]))?;
        let rate_hz = own.rate_hz;
        let at_rate = |parent: &Parent| {
            if parent.subject.movement.rate_hz == rate_hz {
                parent.figures.clone()
            } else {
                Figures::of_parent(&parent.subject.movement, rate_hz, &self.reference)
            }
        };
        let (own, of_base, of_donor) = (Figures::of(&own, &self.reference), at_rate(&base), at_rate(&donor));
        let cyclic = Rule::from_name(&job.recipe.rule).is_some_and(Rule::is_cyclic);
        let Verdict { accepted, reasons, .. } = judge(&own, &of_base, &of_donor, cyclic, &self.settings.gates);
        let range = |range: [usize; 2]| Some(range.map(|frame| frame as u32));
        let made = Made {
            recipe: job.recipe.recipe.clone(),
            clip_id: accepted.then_some(work.job().clip_id),
            accepted,
            reasons,
            base_range: range(grafted.base_range),
            donor_range: range(grafted.donor_range),
            figures: figure_rows(&own, &of_base, Some(&of_donor)),
        };
        if !accepted {
            return Err(Out::Rejected(Box::new(made)));
        }
        let provenance = grafted.provenance.rows(job.base, job.donor).collect();
        work.outcome = Some(Outcome { made, provenance });
        Ok(())
    }

    fn parent(&mut self, clip_id: u32) -> Result<Rc<Parent>, Out> {
        if let Some(parent) = self.parents.iter().find(|parent| parent.clip_id == clip_id) {
            return Ok(Rc::clone(parent));
        }
        let parent = Rc::new(self.load(clip_id)?);
        if self.parents.len() == PARENTS_KEPT {
            self.parents.pop_front();
        }
        self.parents.push_back(Rc::clone(&parent));
        Ok(parent)
    }

    fn load(&self, clip_id: u32) -> Result<Parent, Out> {
        let read = || {
            let catalog =
                self.catalog.as_ref().ok_or_else(|| CorpusError::NotThere { what: "the catalog".to_owned() })?;
            let shard = catalog.shard_of(clip_id)?;
            let skeleton = shard.skeleton(clip_id)?;
            Ok::<_, CorpusError>((shard.motion(clip_id)?, skeleton.roles.clone(), skeleton.header.clone()))
        };
        let (clip, roles, header) = read().map_err(|error| unusable(clip_id, &error.to_string()))?;
        let subject = Subject::new(Arc::new(clip), &roles).map_err(|unfit| unusable(clip_id, &unfit.to_string()))?;
        let figures = Figures::of(&subject.movement, &self.reference);
        Ok(Parent { clip_id, subject, header, roles, figures })
    }
}

fn rejected(job: &RecipeJob, reasons: Vec<String>) -> Out {
    Out::Rejected(Box::new(Made { recipe: job.recipe.recipe.clone(), reasons, ..Made::default() }))
}

fn unusable(clip_id: u32, why: &str) -> Out {
    Out::Fault(Notice {
        severity: Severity::Fault,
        kind: "parent-unusable".to_owned(),
        line: None,
        frame: None,
        count: 1,
        message: format!("clip {clip_id} can't be a parent: {why}"),
        why: "a clip is made of what its parents hold".to_owned(),
        remedy: "run `motionmill verify` on the corpus".to_owned(),
    })
}
