#include "daemon/config/light_plausibility.hpp"

#include <cmath>
#include <string>
#include <variant>

namespace contourd {
namespace {

std::string ms_text(Duration duration) {
  return std::to_string(std::llround(in_ms(duration))) + " ms";
}

}  // namespace

void warn_of_implausible_light(JsonDocument& printer, const ProjectorConfig& projector,
                               const ExposureTolerance& tolerance, Duration exposure) {
  const auto* const serial = std::get_if<SerialProjectorConfig>(&projector);
  if (serial == nullptr || !serial->table.switches_light()) return;
  const ProjectorTable& table = serial->table;
  const auto warn = [&printer](const std::string& what) { printer.add_warning("/projector/table", what); };
  const std::string tolerated = "the resin's exposure_tolerance_ms is " + ms_text(tolerance.bounds) +
                                (tolerance.policy == ExposureTolerance::Policy::Interrupt
                                     ? ", so every layer will wait for the operator"
                                     : ", so every layer will cause a warning");
  const Duration commands = table.wire_time(*table.light_on) + table.wire_time(*table.light_off);
  if (commands > tolerance.bounds) {
    warn("light_on and light_off alone take " + ms_text(commands) + " at " + std::to_string(table.baud) +
         " baud: " + tolerated);
  }
  if (table.latency > tolerance.bounds) {
    warn("its latency_ms is " + ms_text(table.latency) +
         ", and light_off is hardly faster than light_on: " + tolerated);
  }
  const Duration soonest = table.wire_time(*table.light_on) + table.gap;
  if (soonest > exposure) {
    warn("its gap_ms is " + ms_text(table.gap) + ": light_off comes " + ms_text(soonest) +
         " after light_on at the soonest, but the resin's exposure is " + ms_text(exposure) +
         ": layers with this exposure get more light");
  }
  if (table.light_on->timeout >= exposure) {
    warn("the reply to light_on may take " + ms_text(table.light_on->timeout) +
         ", but the resin's exposure is " + ms_text(exposure) +
         ": a lost reply is noticed only after the exposure, and then it is unknown whether there was light");
  }
}

}  // namespace contourd
