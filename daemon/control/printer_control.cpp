#include "daemon/control/printer_control.hpp"

#include <fmt/format.h>

#include <optional>

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
       changes("Confirms that the plate is clear, and that the user has checked the printer if "
               "the queue was held.",
               &PrinterControl::plate_cleared)}};
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

Json PrinterControl::plate_cleared() {
  if (has_unfinished_job()) throw ControlRefusal(fmt::format("{} is being printed", job_.name()));
  if (hold_.plate_occupant()) context_.log.info("plate", "the plate is clear");
  hold_.set_plate_occupant(std::nullopt);
  hold_.release();
  scheduler_.run();
  return status_.status();
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
