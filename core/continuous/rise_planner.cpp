#include "core/continuous/rise_planner.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// A slab of a rise: the speeds that hold in all of it.
struct Stage {
  Nanometers bottom, top;
  MillimetersPerSecond steady{};  // if the plate has moved so for long
  MillimetersPerSecond start{};   // through the gap that the dead zone leaves
  Millimeters own{};              // distance of its slab
  Millimeters distance{};         // the larger one of that and of the slab beneath
  RiseLimit limit{};
  MillimetersPerSecond speed{};  // planned
  // Speed before the change, and whether this stage lies above it, in a slab in which the bounds change.
  MillimetersPerSecond most{std::numeric_limits<double>::infinity()};
  bool is_upper_part = false;
};
using Stages = std::span<Stage>;

double square(MillimetersPerSecond speed) {
  return speed.count() * speed.count();
}

// Returns the speed after accelerating over a distance.
MillimetersPerSecond after(MillimetersPerSecond speed, const Stage& stage, const RiseBounds& bounds) {
  // Ramps are rounded up to whole nanometres.
  const double length_mm = in_mm(stage.top - stage.bottom - Nanometers{2});
  return MillimetersPerSecond{std::sqrt(square(speed) + 2 * bounds.acceleration.count() * length_mm)};
}

// A place between slabs: height, and distance of the slab beneath, whose sections are lit until their resin
// has gelled; 0 if the rise begins here.
struct SlabBottom {
  Nanometers height{};
  Millimeters distance{};
};

Stage stage_of(const RiseSlab& slab, const SlabBottom& bottom, const RiseBounds& bounds) {
  const MillimetersPerSecond cure = cure_speed(bounds.lit, bounds.margin);
  const MillimetersPerSecond most = std::min(cure, bounds.fastest);
  Stage stage{bottom.height, slab.top};
  stage.own = slab.distance;
  stage.distance = std::max(slab.distance, bottom.distance);
  stage.steady = steady_refill_speed(bounds.refill, bounds.lit, stage.distance, most);
  stage.start = std::min(most, refill_speed(bounds.refill, bounds.lit.dead_zone, stage.distance));
  stage.limit = stage.steady < most     ? RiseLimit::Refill
                : bounds.fastest < cure ? RiseLimit::Machine
                                        : RiseLimit::Cure;
  return stage;
}

// Returns the speeds at which the plate passes from stage to stage, from rest to rest.
std::vector<MillimetersPerSecond> passing_speeds(std::span<const Stage> stages, const RiseBounds& bounds) {
  std::vector<MillimetersPerSecond> speeds(stages.size() + 1);
  for (std::size_t i = 1; i < stages.size(); ++i)
    speeds[i] = std::min({stages[i - 1].speed, stages[i].speed, after(speeds[i - 1], stages[i - 1], bounds)});
  for (std::size_t i = stages.size(); i-- > 1;)
    speeds[i] = std::min(speeds[i], after(speeds[i + 1], stages[i], bounds));
  return speeds;
}

// Returns the slowest speed since the resin at the lower end of a stage entered the gap, in the two slabs
// beneath; 0 if that was before the rise.
MillimetersPerSecond slowest_beneath(std::size_t stage, std::span<const Stage> stages,
                                     std::span<const MillimetersPerSecond> passing) {
  MillimetersPerSecond slowest{std::numeric_limits<double>::infinity()};
  for (int slabs = 0; slabs < 2; --stage) {
    if (stage == 0) return MillimetersPerSecond{};
    slowest = std::min({slowest, passing[stage], stages[stage - 1].speed});
    if (!stages[stage - 1].is_upper_part) ++slabs;
  }
  return slowest;
}

// Slows the stages down to what resin can follow through the gap of the stage before. False if none was too
// fast.
bool slow_down(Stages stages, const RiseBounds& bounds) {
  const std::vector<MillimetersPerSecond> passing = passing_speeds(stages, bounds);
  bool slowed = false;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    Stage& stage = stages[i];
    const MillimetersPerSecond slowest = slowest_beneath(i, stages, passing);
    const Micrometers gap = gel_gap(bounds.lit, margin_at(bounds.lit, slowest));
    const MillimetersPerSecond most = refill_speed(bounds.refill, gap, stage.distance);
    if (!(most < stage.speed)) continue;
    stage.speed = most;
    stage.limit = RiseLimit::Refill;
    slowed = true;
  }
  return slowed;
}

// Plans the speeds of the stages of one rise.
void plan_speeds(Stages stages, const RiseBounds& bounds) {
  for (Stage& stage : stages)
    stage.speed = std::min(stage.steady, stage.most);
  // Slower stages before make slower ones after them, and rarely the other way round.
  constexpr int kPasses = 50;
  for (int pass = 0; pass < kPasses; ++pass)
    if (!slow_down(stages, bounds)) return;
  for (Stage& stage : stages) {
    const MillimetersPerSecond start = std::min(stage.start, stage.most);
    if (start < stage.speed) stage.limit = RiseLimit::Refill;
    stage.speed = start;
  }
}

// Returns the length of a ramp between two speeds, rounded up.
Nanometers ramp(MillimetersPerSecond from, MillimetersPerSecond to, const RiseBounds& bounds) {
  const double length_mm = std::fabs(square(to) - square(from)) / (2 * bounds.acceleration.count());
  return Nanometers{static_cast<std::int64_t>(std::ceil(length_mm * 1e6))};
}

// Adds a stage's ramps and the way between them, up to its top.
void add_stage(const Stage& stage, MillimetersPerSecond from, MillimetersPerSecond to,
               const RiseBounds& bounds, RisePlan& plan) {
  const double length_mm = in_mm(stage.top - stage.bottom - Nanometers{2});
  const MillimetersPerSecond reached{
      std::sqrt((square(from) + square(to)) / 2 + bounds.acceleration.count() * length_mm)};
  const MillimetersPerSecond peak = std::max({from, to, std::min(stage.speed, reached)});
  const RiseLimit limit = peak < stage.speed ? RiseLimit::Machine : stage.limit;
  const Nanometers begin = stage.bottom + ramp(from, peak, bounds), end = stage.top - ramp(peak, to, bounds);
  plan.points.back().limit = begin > stage.bottom ? RiseLimit::Machine : limit;
  if (begin > stage.bottom) plan.points.push_back({begin, peak, limit});
  if (end < stage.top && end > plan.points.back().height)
    plan.points.push_back({end, peak, RiseLimit::Machine});
  plan.points.push_back({stage.top, to, RiseLimit::Machine});
}

// Returns how far the plate goes on above a rise: by the gel gap of the fastest speed that resin still has
// light from.
Nanometers overrun_of(const RisePlan& plan, const RiseBounds& bounds) {
  const Nanometers top = plan.points.back().height;
  const Nanometers reach{std::llround(gel_gap(bounds.lit, bounds.margin).count() * 1000)};
  MillimetersPerSecond fastest = speed_at(plan, std::max(top - reach, plan.points.front().height));
  for (const RisePoint& point : plan.points)
    if (point.height > top - reach) fastest = std::max(fastest, point.speed);
  const Micrometers gap = gel_gap(bounds.lit, margin_at(bounds.lit, fastest));
  return std::clamp(bounds.travel - top, Nanometers{}, Nanometers{std::llround(gap.count() * 1000)});
}

RisePlan rise_of(Stages stages, const RiseBounds& bounds) {
  plan_speeds(stages, bounds);
  const std::vector<MillimetersPerSecond> passing = passing_speeds(stages, bounds);
  RisePlan plan{{{stages.front().bottom, MillimetersPerSecond{}, RiseLimit::Machine}}};
  for (std::size_t i = 0; i < stages.size(); ++i)
    add_stage(stages[i], passing[i], passing[i + 1], bounds, plan);
  plan.overrun = overrun_of(plan, bounds);
  return plan;
}

// Returns the number of stages that a rise passes within a time.
std::size_t stages_within(const RisePlan& rise, std::span<const Stage> stages,
                          std::chrono::duration<double> time) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < rise.points.size(); ++i) {
    time -= duration(rise.points[i - 1], rise.points[i]);
    if (time.count() < 0) break;
    if (rise.points[i].height == stages[count].top) ++count;
  }
  return count;
}

// Plans a rise through as many stages, from the first, as the window has oxygen for. No points if it has not
// enough for the first.
RisePlan plan_rise(Stages stages, const RiseBounds& bounds) {
  std::size_t count = stages.size();
  RisePlan rise = rise_of(stages, bounds);
  const auto whole = [&rise] { return duration(with_overrun(rise)); };
  while (whole() > bounds.window) {
    count = std::min(count - 1, stages_within(rise, stages, bounds.window - (whole() - duration(rise))));
    if (count == 0) return {};
    rise = rise_of(stages.first(count), bounds);
  }
  if (count < stages.size()) rise.points[rise.points.size() - 2].limit = RiseLimit::Oxygen;
  return rise;
}

// True if a rise from the first stage is never slower than the slowest, but for its ramps: through the gap
// of the dead zone alone go the first two.
bool can_begin(std::span<const Stage> stages, const RiseBounds& bounds) {
  return std::ranges::all_of(stages.first(std::min<std::size_t>(stages.size(), 2)),
                             [&](const Stage& stage) { return stage.start >= bounds.slowest; });
}

// Adds the rises of stages that lie on each other: one, or several where the window's oxygen is used up.
void add_rises(Stages stages, const RiseBounds& bounds, std::vector<RisePlan>& rises) {
  bool rests = false;
  while (!stages.empty()) {
    Stage& first = stages.front();
    if (!rests) first = stage_of({first.top, first.own}, {first.bottom}, bounds);
    const bool is_high = rests || stages.back().top - stages.front().bottom >= kLowestRise;
    RisePlan rise = is_high && can_begin(stages, bounds) ? plan_rise(stages, bounds) : RisePlan{};
    rests = !rise.points.empty();
    const Nanometers top = rests ? rise.points.back().height : stages.front().top;
    if (rests) rises.push_back(std::move(rise));
    while (!stages.empty() && stages.front().top <= top)
      stages = stages.subspan(1);
  }
}

// Returns the slabs of a rise, joined to slabs at least as thick as the gap.
std::vector<RiseSlab> slabs_of(const RisePlan& rise, std::span<const RiseSlab> slabs, Micrometers gap) {
  const Nanometers bottom = rise.points.front().height, top = rise.points.back().height;
  std::vector<RiseSlab> joined;
  Nanometers from = bottom;
  Millimeters distance{};
  for (const RiseSlab& slab : slabs) {
    if (slab.top <= bottom || slab.top > top) continue;
    distance = std::max(distance, slab.distance);
    if (in_mm(slab.top - from) * 1000 < gap.count()) continue;
    joined.push_back({slab.top, distance});
    from = slab.top;
    distance = Millimeters{};
  }
  if (joined.empty()) joined.push_back({from, distance});
  joined.back().top = top;
  joined.back().distance = std::max(joined.back().distance, distance);
  return joined;
}

// Returns the slowest speed of a rise within a span, but for its ramps from and to rest.
MillimetersPerSecond slowest_within(const RisePlan& rise, Nanometers low, Nanometers high) {
  MillimetersPerSecond slowest{std::numeric_limits<double>::infinity()};
  const auto add = [&](MillimetersPerSecond speed) {
    if (speed > MillimetersPerSecond{}) slowest = std::min(slowest, speed);
  };
  add(speed_at(rise, low));
  add(speed_at(rise, high));
  for (const RisePoint& point : rise.points)
    if (point.height > low && point.height < high) add(point.speed);
  return slowest;
}

// Adds a slab's stage, or two if the bounds change within it.
void add_changed(const Stage& stage, const RiseChange& change, std::vector<Stage>& stages) {
  constexpr Nanometers kLeastPart{1'000};
  stages.push_back(stage);
  if (change.from < stage.bottom + kLeastPart) return;
  Stage& lower = stages.back();
  lower.top = std::min(stage.top, change.from);
  if (stage.top < change.from + kLeastPart) lower.top = stage.top;
  lower.most = slowest_within(change.before, lower.bottom, lower.top) * change.light;
  if (lower.top == stage.top) return;
  Stage upper = stage;
  upper.bottom = lower.top;
  upper.is_upper_part = true;
  stages.push_back(upper);
}

// True if the slabs are those of a sweep for these bounds.
bool are_thick(std::span<const RiseSlab> slabs, const RiseBounds& bounds) {
  const Micrometers gap = gel_gap(bounds.lit, bounds.margin);
  Nanometers bottom{};
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    const double thickness_um = in_mm(slabs[i].top - bottom) * 1000;
    if (thickness_um < (i + 1 < slabs.size() ? gap.count() : 1)) return false;
    bottom = slabs[i].top;
  }
  return true;
}

}  // namespace

std::vector<RisePlan> plan_rises(std::span<const RiseSlab> slabs, Nanometers from, const RiseBounds& bounds) {
  expects(are_thick(slabs, bounds), "slabs are as thick as the gel gap");
  expects(bounds.fastest > MillimetersPerSecond{} && bounds.slowest > MillimetersPerSecond{} &&
              bounds.acceleration > MillimetersPerSecondSquared{} && bounds.window.count() > 0,
          "a rise has speeds, an acceleration and a window");
  std::vector<RisePlan> rises;
  std::vector<Stage> stages;
  SlabBottom bottom;
  for (const RiseSlab& slab : slabs) {
    const Stage stage = stage_of(slab, {bottom.height}, bounds);
    if (bottom.height >= from && stage.steady >= bounds.slowest) {
      stages.push_back(stages.empty() ? stage : stage_of(slab, bottom, bounds));
    } else {
      add_rises(stages, bounds, rises);
      stages.clear();
    }
    bottom = {slab.top, slab.distance};
  }
  add_rises(stages, bounds, rises);
  return rises;
}

ChangedRise change_rise(std::span<const RiseSlab> slabs, const RiseChange& change, const RiseBounds& bounds) {
  expects(change.before.points.size() > 2 && change.light > 0, "a rise was planned, and has light");
  std::vector<Stage> stages;
  SlabBottom bottom{change.before.points.front().height};
  for (const RiseSlab& slab : slabs_of(change.before, slabs, gel_gap(bounds.lit, bounds.margin))) {
    add_changed(stage_of(slab, bottom, bounds), change, stages);
    bottom = {slab.top, slab.distance};
  }
  ChangedRise changed{rise_of(stages, bounds), MillimetersPerSecond{std::numeric_limits<double>::infinity()}};
  // Above the top, the resin at the top still needs the light of the gap with which the plate has come there.
  if (change.from > change.before.points.back().height)
    changed.plan.overrun = std::max(changed.plan.overrun, change.before.overrun);
  for (const Stage& stage : stages) {
    if (stage.top <= change.from || stage.speed >= changed.slowest) continue;
    changed.slowest = stage.speed;
    changed.slowest_at = std::max(stage.bottom, change.from);
  }
  return changed;
}

}  // namespace contourd
