#include "daemon/control/interrupted_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/jobs/job_reader.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Returns why the job cannot go on as it began; empty if it can.
std::string trouble_of(const JobMarks& now, const JobMarks& before) {
  if (now.files.empty() || now.files != before.files)
    return "the print cannot go on: its model or its ticket has changed since it began";
  if (now.settings != before.settings)
    return "the print cannot go on: the resin's profile, or the printer's display, light, supports or "
           "microsteps, have changed since it began; restore them, or see \"contourctl rescue\"";
  return "";
}

}  // namespace

using Json = InterruptedControl::Json;

ControlMethods InterruptedControl::methods() {
  return {
      {"go_on",
       {.description = "Continues the print that a power cut ended, once the plate's position is known.",
        .parameters = {ControlParameter::flag(
            "trust_position", "true to trust the recorded position: see `interrupted.trust` of the status")},
        .changes = true,
        .call_later =
            [this](const Json& given, const ControlCaller&, const ControlMethod::Later& later) {
              go_on(given.value("trust_position", false), later);
            }}},
      {"rescue",
       {.description = "Lifts the part out of the resin after a power cut has ended its print: the plate "
                       "moves up, and nothing else happens.",
        .call = [this](const Json&, const ControlCaller&) { return rescue(); },
        .changes = true,
        .needs_service_rights = true}}};
}

const InterruptedPrint& InterruptedControl::require_interrupted() const {
  if (!parts_.hold.interrupted()) throw ControlRefusal("no print was interrupted by a power cut");
  if (parts_.use.has_job()) throw ControlRefusal("another job is being printed");
  if (parts_.use.controlled_by_hand())
    throw ControlRefusal("the printer is controlled by hand; \"contourctl stop\" ends that");
  return *parts_.hold.interrupted();
}

Json InterruptedControl::rescue() {
  (void)require_interrupted();
  const std::vector<std::string> troubles = context_.machine.z_axis().why_not_ready();
  if (!troubles.empty())
    throw ControlRefusal(fmt::format("the plate cannot be moved: {}", fmt::join(troubles, "; ")));
  const std::string lit = context_.machine.projector().light_off_unconfirmed();
  if (!lit.empty()) throw ControlRefusal("the plate is not moved because the light may be on: " + lit);
  const Nanometers way = way_out();
  parts_.hold.interrupted_moves(way);
  parts_.manual.raise(way, kNudgeSpeed);
  return parts_.status.status();
}

Nanometers InterruptedControl::way_out() const {
  const ZAxis& axis = context_.machine.z_axis();
  if (axis.homes_upwards()) return axis.travel();
  const auto& plate = parts_.hold.interrupted()->progress.print.plate;
  if (!plate)
    throw ControlRefusal(
        "the plate is not lifted: its height is not known, and there is no limit switch at the top");
  const Nanometers room = axis.travel() - plate->most;
  if (room <= Nanometers{}) throw ControlRefusal("the plate may be at the top of its travel already");
  return std::min(context_.config.manual.vat_depth, room);
}

void InterruptedControl::go_on(bool trusted, const ControlMethod::Later& later) {
  const InterruptedPrint& interrupted = require_interrupted();
  const bool upwards = context_.machine.z_axis().homes_upwards();
  if (const std::string not_ready = context_.machine.why_not_ready(); !not_ready.empty())
    throw ControlRefusal("the print cannot go on: " + not_ready);
  if (const std::string why = why_not_resumable(interrupted, upwards, trusted); !why.empty())
    throw ControlRefusal("the print cannot go on: " + why);
  const ClaimedJob::Resumed resumed{interrupted, resume_point(interrupted.progress, trusted)};
  const auto look = [&spool = parts_.spool, &config = context_.config, files = interrupted.files,
                     marks = interrupted.progress.marks]() -> Look {
    try {
      Look found{read_settings(files, config), ""};
      found.trouble = trouble_of(marks_of(files, found.settings->resin.name, config), marks);
      // From here on the print is under way again: its end is yet to come.
      if (found.trouble.empty()) spool.ends().release_name(files.name);
      return found;
    } catch (const std::exception& error) {
      return {std::nullopt, fmt::format("the print cannot go on: {}", printable(error.what()))};
    }
  };
  parts_.spool.run(look, [this, resumed, later](const Look& found) { looked_at(resumed, found, later); });
}

void InterruptedControl::go_on_by_policy() {
  const bool wanted = context_.config.resumes_after_power_cut && parts_.hold.interrupted();
  if (!wanted || tried_ || !context_.machine.why_not_ready().empty()) return;
  tried_ = true;
  if (parts_.hold.interrupted()->ended_reading)
    return context_.log.warning(
        "interrupted",
        "contourd ended while it read the interrupted print's model: it tries again only when "
        "a user resumes the print");
  const auto note = [this](const ControlRefusal& refusal) {
    context_.log.warning("interrupted", refusal.what());
  };
  try {
    go_on(false, [note](const std::variant<Json, ControlRefusal>& result) {
      if (const auto* const refusal = std::get_if<ControlRefusal>(&result)) note(*refusal);
    });
  } catch (const ControlRefusal& refusal) {
    note(refusal);
  }
}

void InterruptedControl::looked_at(const ClaimedJob::Resumed& resumed, const Look& look,
                                   const ControlMethod::Later& later) {
  try {
    if (!look.trouble.empty()) throw ControlRefusal(look.trouble);
    const InterruptedPrint& interrupted = require_interrupted();
    const JobFiles files = interrupted.files;
    // The plate may have been moved meanwhile.
    if (interrupted.progress.print != resumed.print.progress.print)
      throw ControlRefusal("the print cannot go on: the plate was moved by hand since the power cut");
    parts_.hold.set_interrupted(std::nullopt);
    // A print that has begun was accepted.
    parts_.use.begin({.files = files,
                      .settings = look.settings,
                      .turn_came = std::chrono::steady_clock::now(),
                      .accepted = {kFoundByPreparation.begin(), kFoundByPreparation.end()},
                      .resumed = resumed});
    later(parts_.status.status());
  } catch (const ControlRefusal& refusal) {
    later(refusal);
  }
}

}  // namespace contourd
