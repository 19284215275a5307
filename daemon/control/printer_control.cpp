#include "daemon/control/printer_control.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd {

using Json = PrinterControl::Json;

ControlMethods PrinterControl::methods() {
  const auto changes = [this](const char* description, Json (PrinterControl::*method)()) {
    return ControlMethod{
        .description = description,
        .call = [this, method](const Json&, const ControlCaller&) { return (this->*method)(); },
        .changes = true};
  };
  return {
      {"status",
       {.description = "Reports the printer's current activity, the waiting jobs and the reasons.",
        .call = [this](const Json&, const ControlCaller&) { return status_.status(); }}},
      {"pause",
       changes("Pauses the print after the current layer, or before the first one: the plate goes up "
               "and the print waits.",
               &PrinterControl::pause)},
      {"resume", changes("Continues a paused or interrupted print, withdraws a requested pause that has not "
                         "begun, or releases a held queue.",
                         &PrinterControl::resume)},
      {"cancel", changes("Ends the current print: light off, plate up, the job under `failed/`.",
                         &PrinterControl::cancel)},
      {"plate_cleared",
       {.description = "Confirms that the plate is clear, and that the user has checked the printer if "
                       "the queue was held.",
        .changes = true,
        .call_later = [this](const Json&, const ControlCaller&, ControlMethod::Later later) {
          plate_cleared(std::move(later));
          return std::nullopt;
        }}}};
}

Json PrinterControl::pause() {
  require_print("pause");
  PrintMode& print = job_.print();
  if (print.next_pause().empty()) throw ControlRefusal(std::string(print.why_it_ends()));
  print.pause();
  return status_.status();
}

Json PrinterControl::resume() {
  if (hold_.reason() && !has_unfinished_job()) return resume_queue();
  require_print("resume");
  PrintMode& print = job_.print();
  if (!print.can_resume()) throw ControlRefusal("the print is not paused");
  require_ready("the print");
  hold_.release();
  print.resume();
  return status_.status();
}

Json PrinterControl::resume_queue() {
  require_ready("the queue");
  hold_.release();
  scheduler_.run();
  return status_.status();
}

Json PrinterControl::cancel() {
  if (!has_unfinished_job()) throw ControlRefusal("there is no print to cancel");
  const PrintMode& print = job_.print();
  if (print.under_way() && !print.can_cancel()) throw ControlRefusal(std::string(print.why_it_ends()));
  job_.cancel();
  return status_.status();
}

void PrinterControl::plate_cleared(ControlMethod::Later later) {
  if (has_unfinished_job()) throw ControlRefusal(fmt::format("{} is being printed", job_.name()));
  if (hold_.plate_occupant()) context_.log.info("plate", "the plate is clear");
  hold_.release();
  const auto reply = std::make_shared<Json>();
  hold_.set_plate_occupant(std::nullopt, [reply, later = std::move(later)](const std::string& trouble) {
    if (trouble.empty()) return later(*reply);
    later(
        ControlRefusal("the plate counts as clear, but contourd will ask again after a restart, because this "
                       "cannot be recorded: " +
                       printable(trouble)));
  });
  scheduler_.run();
  *reply = status_.status();
}

void PrinterControl::require_ready(std::string_view what) const {
  if (const std::string not_ready = context_.machine.why_not_ready(); !not_ready.empty())
    throw ControlRefusal(fmt::format("{} cannot go on: {}", what, not_ready));
}

bool PrinterControl::has_unfinished_job() const {
  return job_.job() != nullptr && !job_.finishing();
}

void PrinterControl::require_print(std::string_view what) const {
  if (!job_.print().under_way()) throw ControlRefusal(fmt::format("there is no print to {}", what));
}

}  // namespace contourd
