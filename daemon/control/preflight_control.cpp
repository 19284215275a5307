#include "daemon/control/preflight_control.hpp"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include "daemon/prepare/resin_temperature.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

using Json = PreflightControl::Json;

ControlMethods PreflightControl::methods() {
  return {{"vat",
           {.description = "Reports how much resin the vat holds, or records the amount after filling.",
            .parameters = {ControlParameter::number("filled_ml", 0, 100'000, "ml",
                                                    "the amount of resin in the vat after filling")},
            .changes = true,
            .reports_when_bare = true,
            .call_later = [this](const Json& given, const ControlCaller&,
                                 ControlMethod::Later later) { return vat(given, std::move(later)); }}},
          {"preflight",
           {.description = "Checks printer and job before the job's first light, and changes nothing.",
            .parameters =
                {ControlParameter::text("job", "the job: its file in `incoming/`, or its name").needed()},
            .call_later = [this](const Json& given, const ControlCaller& caller, ControlMethod::Later later) {
              preflight(given["job"].get<std::string>(), caller, std::move(later));
            }}}};
}

Json PreflightControl::vat_json() const {
  return {{"ml", or_null(parts_.vat.ml())}};
}

void PreflightControl::vat(const Json& given, ControlMethod::Later later) {
  const auto filled_ml = given_value<double>(given, "filled_ml");
  if (!filled_ml) return later(vat_json());
  parts_.vat.fill(*filled_ml, [this, later = std::move(later)](const std::string& trouble) {
    if (trouble.empty()) return later(vat_json());
    later(ControlRefusal("the vat counts as filled until contourd stops, because this cannot be recorded: " +
                         printable(trouble)));
  });
}

PreflightFacts PreflightControl::facts() const {
  MaskDisplay& display = context_.machine.display();
  PreflightFacts facts;
  facts.not_ready = context_.machine.why_not_ready();
  if (facts.not_ready.empty()) facts.not_ready = force_at_rest(context_.machine);
  facts.queue_waits = parts_.hold.reason_to_wait();
  const double frame_s = std::chrono::duration<double>(display.frame()).count();
  facts.display = fmt::format("{} x {} pixels at {:.4g} Hz", display.width().count(),
                              display.height().count(), frame_s > 0 ? 1 / frame_s : 0);
  facts.vat_ml = parts_.vat.ml();
  facts.due = parts_.reminders.due();
  return facts;
}

void PreflightControl::preflight(const std::string& job, const ControlCaller& caller,
                                 ControlMethod::Later later) {
  const std::string file = parts_.queue.jobs()[parts_.queue_control.number_of(job)].file;
  const auto facts = std::make_shared<PreflightFacts>(this->facts());
  const auto answer = [this, file, job, facts, later = std::move(later)] {
    const auto& jobs = parts_.queue.jobs();
    const auto found = std::ranges::find(jobs, file, &WaitingJob::file);
    if (found == jobs.end()) return later(ControlRefusal(fmt::format("{} no longer waits", in_quotes(job))));
    later(preflight_json(file, contourd::preflight(*found, *facts)));
  };
  const auto ask_history = [this, caller, facts, answer] {
    parts_.history.usage(
        caller, [facts, answer](const std::optional<HistoryWorker::AllUsage>& usage, const std::string&) {
          if (usage) facts->wear = usage->wear;
          answer();
        });
  };
  parts_.spool.run(
      [&spool = parts_.spool, file, &config = context_.config] {
        PreflightFacts found;
        found.disk_trouble = look_at(spool, file, config).disk_trouble;
        if (!config.resin_temperature) return found;
        try {
          found.resin_c = read_temperature(*config.resin_temperature);
        } catch (const std::exception& error) {
          found.resin_trouble = error.what();
        }
        return found;
      },
      [facts, ask_history](const PreflightFacts& found) {
        facts->disk_trouble = found.disk_trouble;
        facts->resin_c = found.resin_c;
        facts->resin_trouble = found.resin_trouble;
        ask_history();
      });
}

}  // namespace contourd
