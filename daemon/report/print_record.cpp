#include "daemon/report/print_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

std::string describe(const Exclusion& exclusion) {
  return fmt::format("{} dark from layer {} on", printable(exclusion.copy), exclusion.layer + 1);
}

PrintRecord::PrintRecord(Machine& machine, Clock& clock, std::optional<std::filesystem::path> masks)
    : machine_(machine),
      clock_(clock),
      masks_(std::move(masks)),
      started_(clock.now()),
      late_steps_then_(machine.z_axis().late_steps().count),
      started_at_(std::chrono::system_clock::now()),
      states_(started_) {}

void PrintRecord::add(std::int32_t layer, const PeelRecord& peel) {
  const auto last = std::find_if(layers_.rbegin(), layers_.rend(),
                                 [layer](const LayerRecord& record) { return record.layer <= layer; });
  if (last != layers_.rend() && last->layer == layer) last->peel = peel;
}

void PrintRecord::enter(const PrintState& state, std::int32_t layer) {
  const bool stopped = state.activity == PrintActivity::Stopped;
  const bool was_stopped = states_.state().activity == PrintActivity::Stopped;
  states_.enter(state, clock_.now());
  if (stopped && !was_stopped) {
    pause_known_ = stops_.pauses.size() < PrintStops::kMost;
    if (pause_known_) {
      stops_.pauses.push_back({layer, states_.total(), {}});
    } else {
      ++stops_.more_pauses;
    }
  }
  if (was_stopped && pause_known_) stops_.pauses.back().lasted = states_.total() - stops_.pauses.back().at;
}

void PrintRecord::add_interruption(std::int32_t layer, const std::string& what) {
  if (stops_.interruptions.size() < PrintStops::kMost) {
    stops_.interruptions.push_back({layer, elapsed(), what});
  } else {
    ++stops_.more_interruptions;
  }
}

void PrintRecord::add(const SettingChange& change) {
  expects(changes_.size() < kMostChanges, "there is room for a change");
  const auto last =
      std::ranges::find(changes_.rbegin(), changes_.rend(), change.setting, &SettingChange::setting);
  if (last != changes_.rend() && last->layer == change.layer && last->height == change.height) {
    last->value = change.value;
    if (last->value == last->before) changes_.erase(std::next(last).base());
  } else if (change.value != change.before) {
    changes_.push_back(change);
  }
}

void PrintRecord::add(ChangedForecast plan) {
  if (plan.plan.ranges.empty()) return;
  while (!changed_rises_.empty() && changed_rises_.back().from >= plan.from)
    changed_rises_.pop_back();
  if (!changed_rises_.empty()) end_at(plan.from, changed_rises_.back().plan);
  changed_rises_.push_back(std::move(plan));
}

void PrintRecord::add_lit_turn(const EventLoop::Turn& turn) {
  if (turn.busy > busiest_lit_.busy) busiest_lit_ = turn;
}

TimeByCause PrintRecord::times() const {
  TimeByCause times = time_by_cause(states_);
  times[states_.state().cause] += elapsed() - states_.total();
  return times;
}

PrintReport PrintRecord::take_report() {
  PrintReport report;
  report.layers = std::move(layers_);
  enter(kIdle, 0);
  report.stops = std::move(stops_);
  report.changes = std::move(changes_);
  report.changed_rises = std::move(changed_rises_);
  report.exclusions = std::move(exclusions_);
  report.print_time = states_.total();
  report.states = std::move(states_);
  report.started = started_at_;
  report.ended = std::chrono::system_clock::now();
  report.late_steps = late_steps();
  report.busiest_lit = busiest_lit_;
  report.masks = masks_;
  return report;
}

// Returns the late steps of this print. An axis that was lost and opened again counts from 0 again.
std::uint64_t PrintRecord::late_steps() const {
  const std::uint64_t now = machine_.z_axis().late_steps().count;
  return now >= late_steps_then_ ? now - late_steps_then_ : now;
}

}  // namespace contourd
