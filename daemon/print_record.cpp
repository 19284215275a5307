#include "daemon/print_record.hpp"

#include <fmt/format.h>

#include <utility>

namespace contourd {

PrintRecord::PrintRecord(Machine& machine, Clock& clock, std::optional<std::filesystem::path> masks)
    : machine_(machine),
      clock_(clock),
      masks_(std::move(masks)),
      started_(clock.now()),
      late_steps_then_(machine.z_axis().late_steps().count),
      started_at_(std::chrono::system_clock::now()) {}

void PrintRecord::add_interruption(std::int32_t layer, const std::string& what) {
  interruptions_.push_back(fmt::format("layer {}: {}", layer + 1, what));
}

void PrintRecord::add_lit_turn(const EventLoop::Turn& turn) {
  if (turn.busy > busiest_lit_.busy) busiest_lit_ = turn;
}

PrintReport PrintRecord::take_report() {
  PrintReport report;
  report.layers = std::move(layers_);
  report.interruptions = std::move(interruptions_);
  report.started = started_at_;
  report.ended = std::chrono::system_clock::now();
  report.print_time = elapsed();
  report.late_steps = late_steps();
  report.busiest_lit = busiest_lit_;
  report.masks = masks_;
  return report;
}

// An axis that was lost and opened again counts anew.
std::uint64_t PrintRecord::late_steps() const {
  const std::uint64_t now = machine_.z_axis().late_steps().count;
  return now >= late_steps_then_ ? now - late_steps_then_ : now;
}

}  // namespace contourd
