#include "daemon/control/printer_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/layers/layers.hpp"
#include "daemon/control/setting_bounds.hpp"
#include "daemon/report/plate_copies.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

namespace {

// Limit of the heights at which a pause can be planned, beyond every print.
constexpr double kMostHeight = 10'000;

constexpr std::size_t kMostCopies = 1000;  // that are listed

// Returns the place of the copy with this number or name. Throws ControlRefusal if there is not exactly one.
std::size_t number_of(const std::string& wanted, const std::vector<PlateCopy>& copies) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  if (error == std::errc{} && end == wanted.data() + wanted.size() && number >= 1 && number <= copies.size())
    return number - 1;
  const auto is_meant = [&](const PlateCopy& copy) {
    return copy.name == wanted || printable(copy.name) == wanted;
  };
  const auto found = std::ranges::find_if(copies, is_meant);
  if (found == copies.end())
    throw ControlRefusal(
        fmt::format("there is no copy {} on the plate: give a number from 1 to {}, or a name such as {}",
                    in_quotes(wanted), copies.size(), in_quotes(copies.front().name)));
  if (std::find_if(found + 1, copies.end(), is_meant) != copies.end())
    throw ControlRefusal(fmt::format("more than one copy is called {}: give its number", in_quotes(wanted)));
  return static_cast<std::size_t>(found - copies.begin());
}

// Returns the lower side of the last layer, or the height that it does not exceed.
Nanometers last_bottom(const JobSummary& summary) {
  const LayerSummary& layers = summary.layers;
  if (!layers.adaptive) return layers.thinnest * (layers.count - 1);
  return to_nanometers(Millimeters{summary.height_mm}).value_or(Nanometers{}) - layers.thinnest;
}

std::vector<ControlParameter> pause_parameters() {
  return {ControlParameter::whole_number("at_layer", 1, kMaxLayers,
                                         "the layer before which the print pauses, from 1"),
          ControlParameter::number("at_mm", 0, kMostHeight, "mm",
                                   "the height of the part at which the print pauses")};
}

std::vector<ControlParameter> set_parameters() {
  return {ControlParameter::one_of("setting", {kPrintSettings.begin(), kPrintSettings.end()}, "the setting")
              .needed(),
          ControlParameter::number("value", 0, 1'000'000, "",
                                   "its value: `exposure` in percent of each layer's planned exposure, "
                                   "`lift` in mm, speeds of lifts in mm/s, `rest` in ms; of a rise, `speed` "
                                   "in mm/h at most, `light` in percent, and `margin`, the minimum ratio of "
                                   "the dose to the critical energy")
              .needed()
              .described_as("a number from 0 to 1000000")};
}

}  // namespace

using Json = PrinterControl::Json;

ControlMethods PrinterControl::methods() {
  const auto changes = [this](const char* description, Json (PrinterControl::*method)()) {
    return ControlMethod{
        .description = description,
        .call = [this, method](const Json&, const ControlCaller&) { return (this->*method)(); },
        .changes = true};
  };
  using Later = ControlMethod::Later;
  const auto changes_later = [this](const char* description, void (PrinterControl::*method)(Later)) {
    return ControlMethod{.description = description,
                         .changes = true,
                         .call_later = [this, method](const Json&, const ControlCaller&, Later later) {
                           (this->*method)(std::move(later));
                         }};
  };
  return {
      {"status",
       {.description = "Reports the printer's current activity, the waiting jobs and the reasons.",
        .call = [this](const Json&, const ControlCaller&) { return status_.status(); }}},
      {"pause",
       {.description = "Pauses the print after the current layer, before the first one, or at the point that "
                       "a parameter names: the plate goes up and the print waits.",
        .parameters = pause_parameters(),
        .call = [this](const Json& parameters, const ControlCaller&) { return pause(parameters); },
        .changes = true}},
      {"set",
       {.description = "Changes a setting of the print from the next layer on, or of a plate that rises in "
                       "the light from now on.",
        .parameters = set_parameters(),
        .changes = true,
        .call_later = [this](const Json& parameters, const ControlCaller&,
                             Later later) { set(parameters, std::move(later)); }}},
      {"settings",
       {.description = "Reports the settings of the print that `set` changes: their values and bounds.",
        .call = [this](const Json&, const ControlCaller&) { return settings(); }}},
      {"copies",
       {.description = "Lists the copies of models on the plate of the print under way.",
        .call = [this](const Json&, const ControlCaller&) { return copies(); }}},
      {"exclude",
       {.description =
            "Leaves a copy of a model dark from the next layer on; the others are printed as before.",
        .parameters = {ControlParameter::text("copy", "the copy's number or name, see `copies`").needed()},
        .call = [this](const Json& parameters, const ControlCaller&) { return exclude(parameters); },
        .changes = true}},
      {"resume",
       changes_later("Continues a paused or interrupted print, withdraws a requested pause that has not "
                     "begun, or releases a held queue.",
                     &PrinterControl::resume)},
      {"cancel", changes("Ends the current print: light off, plate up, the job under `failed/`.",
                         &PrinterControl::cancel)},
      {"plate_cleared",
       changes_later(
           "Confirms that the plate is clear, and that the user has checked the printer if the queue "
           "was held.",
           &PrinterControl::plate_cleared)}};
}

Json PrinterControl::pause(const Json& parameters) {
  require_print("pause");
  PrintMode& print = job_.print();
  if (print.next_pause().empty()) throw ControlRefusal(std::string(print.why_it_ends()));
  if (parameters.empty()) {
    print.pause();
  } else {
    print.pause_at(pause_point(parameters));
  }
  return status_.status();
}

void PrinterControl::set(const Json& parameters, ControlMethod::Later later) {
  const PrintMode& print = job_.print();
  if (!print.under_way())
    throw ControlRefusal(
        "nothing prints: settings can be changed only during a print; a job's ticket sets them before");
  const auto wanted = parameters.at("setting").get<std::string>();
  const std::string_view setting = *std::ranges::find(kPrintSettings, wanted);
  if (const std::string why = why_not_changed(setting); !why.empty()) throw ControlRefusal(why);
  const auto value = parameters.at("value").get<double>();
  const JobSummary& summary = job_.job()->prepared->summary;
  const Limits<double> bounds = bounds_of(setting);
  if (!bounds.contain(value))
    throw ControlRefusal(
        fmt::format("{} {} is not allowed: the resin's profile {} and the machine allow {:g} to {}", setting,
                    figure_text(setting, value), printable(summary.resin.name), bounds.least,
                    figure_text(setting, bounds.most)));
  constexpr std::size_t kAtOnce = 3;
  if (job_.job()->record->changes().size() + kAtOnce > PrintRecord::kMostChanges)
    throw ControlRefusal(
        fmt::format("this print's settings were changed {} times, and its report lists no more",
                    PrintRecord::kMostChanges));
  if (is_of_rises(setting)) return set_rises(setting, value, std::move(later));
  job_.set(setting, value);
  later(status_.status());
}

void PrinterControl::set_rises(std::string_view setting, double value, ControlMethod::Later later) {
  const PrintSettings settings = with_value(job_.print().settings(), setting, value);
  job_.set_rises(settings.rise, [this, later = std::move(later)](const std::string& refusal) {
    if (!refusal.empty()) return later(ControlRefusal(refusal));
    later(status_.status());
  });
}

Json PrinterControl::settings() const {
  require_print("report the settings of");
  const PrintSettings now = job_.print().settings();
  const bool rises = job_.job()->prepared->summary.continuous.has_value();
  Json list = Json::array();
  for (const std::string_view setting : kPrintSettings) {
    if (is_of_rises(setting) && !rises) continue;
    Json each{{"setting", setting},       {"value", value_of(now, setting)},
              {"unit", unit_of(setting)}, {"least", nullptr},
              {"most", nullptr},          {"fixed", or_null(why_not_changed(setting))}};
    if (each["fixed"].is_null()) {
      const Limits<double> bounds = bounds_of(setting);
      each["least"] = bounds.least;
      each["most"] = bounds.most;
    }
    list.push_back(std::move(each));
  }
  return {{"settings", std::move(list)}};
}

std::string PrinterControl::why_not_changed(std::string_view setting) const {
  const PrintMode& print = job_.print();
  if (!is_of_rises(setting)) {
    try {
      (void)next_layer();
    } catch (const ControlRefusal& refusal) {
      return refusal.what();
    }
  }
  return std::string(print.why_fixed(setting));
}

Limits<double> PrinterControl::bounds_of(std::string_view setting) const {
  expects(why_not_changed(setting).empty(), "the setting can be changed");
  return setting_bounds(setting, job_.job()->prepared->summary, resin_machine(context_.config),
                        is_of_rises(setting) ? job_.print().layer() : next_layer());
}

std::int32_t PrinterControl::next_layer() const {
  const PrintMode& print = job_.print();
  if (print.next_pause().empty()) throw ControlRefusal(std::string(print.why_it_ends()));
  const std::int32_t next = print.layer() + 1;
  if (next >= job_.job()->prepared->summary.layers.count)
    throw ControlRefusal("no layer follows: the last one is under way");
  return next;
}

Json PrinterControl::exclude(const Json& parameters) {
  require_print("exclude a copy from");
  (void)next_layer();
  if (const std::string_view why = job_.print().why_fixed("copies"); !why.empty())
    throw ControlRefusal(std::string(why));
  const std::vector<PlateCopy> copies = copies_of(job_.job()->prepared->summary, job_.name());
  const std::size_t number = number_of(parameters.at("copy").get<std::string>(), copies);
  const std::string name = printable(copies[number].name);
  const auto& excluded = job_.job()->record->exclusions();
  const auto known = std::ranges::find(excluded, number, &Exclusion::number);
  if (known != excluded.end())
    throw ControlRefusal(fmt::format("{} is dark from layer {} on already", name, known->layer + 1));
  if (excluded.size() + 1 == copies.size())
    throw ControlRefusal(fmt::format("{} is the last copy that is printed: cancel ends the print", name));
  job_.exclude(number);
  return status_.status();
}

Json PrinterControl::copies() const {
  require_print("list the copies of");
  const auto& excluded = job_.job()->record->exclusions();
  Json list = Json::array();
  const std::vector<PlateCopy> copies = copies_of(job_.job()->prepared->summary, job_.name());
  for (std::size_t i = 0; i < std::min(copies.size(), kMostCopies); ++i) {
    const auto known = std::ranges::find(excluded, i, &Exclusion::number);
    list.push_back({{"number", i + 1},
                    {"name", copies[i].name},
                    {"position_mm", {copies[i].center.x, copies[i].center.y}},
                    {"excluded_from", known == excluded.end() ? Json() : Json(known->layer + 1)}});
  }
  return {{"copies", list}, {"more", copies.size() - list.size()}};
}

PausePoint PrinterControl::pause_point(const Json& parameters) const {
  const auto layer = given_value<std::int32_t>(parameters, "at_layer");
  const auto height_mm = given_value<double>(parameters, "at_mm");
  if (layer && height_mm) throw InvalidParameters("give either at_layer or at_mm");
  const PrintMode& print = job_.print();
  const JobSummary& summary = job_.job()->prepared->summary;
  const auto under_way = print.layer() + 1;
  if (layer && *layer <= under_way)
    throw ControlRefusal(fmt::format("a pause before layer {} comes too late: layer {} of {} is under way",
                                     *layer, under_way, summary.layers.count));
  if (layer && *layer > summary.layers.count)
    throw ControlRefusal(
        fmt::format("there is no layer {} to pause before: the print has {}", *layer,
                    count_of(static_cast<std::uint64_t>(summary.layers.count), "layer", "layers")));
  if (layer) return *layer - 1;
  const Nanometers height = to_nanometers(Millimeters{*height_mm}).value_or(Nanometers{});
  const Nanometers reached = print.layer_top() - print.layer_thickness();
  if (height <= reached)
    throw ControlRefusal(
        fmt::format("a pause at {:g} mm comes too late: the layer under way lies at {:.3f} mm", *height_mm,
                    to_millimeters(reached).count()));
  if (height > last_bottom(summary))
    throw ControlRefusal(
        fmt::format("there is no layer after a pause at {:g} mm: the last one lies at {:.3f} mm", *height_mm,
                    to_millimeters(last_bottom(summary)).count()));
  return height;
}

void PrinterControl::resume(ControlMethod::Later later) {
  if ((hold_.interrupted() || hold_.part_may_hang()) && !has_unfinished_job())
    throw ControlRefusal(hold_.sentence());
  if (hold_.reason() && !has_unfinished_job()) return later(resume_queue());
  require_resumable();
  job_.leave_pause([this, later = std::move(later)](bool recorded) {
    try {
      if (!recorded)
        throw ControlRefusal(
            "the print stays paused: the disk does not answer, and after a power cut the plate would be "
            "taken to be where it is now");
      require_resumable();
      hold_.release();
      job_.print().resume();
      later(status_.status());
    } catch (const ControlRefusal& refusal) {
      later(refusal);
    }
  });
}

void PrinterControl::require_resumable() const {
  require_print("resume");
  if (!job_.print().can_resume()) throw ControlRefusal("the print is not paused");
  require_ready("the print");
}

Json PrinterControl::resume_queue() {
  require_ready("the queue");
  hold_.release();
  scheduler_.run();
  return status_.status();
}

Json PrinterControl::cancel() {
  if (!has_unfinished_job())
    throw ControlRefusal(hold_.interrupted() ? hold_.sentence() : "there is no print to cancel");
  const PrintMode& print = job_.print();
  if (print.under_way() && !print.can_cancel()) throw ControlRefusal(std::string(print.why_it_ends()));
  job_.cancel();
  return status_.status();
}

void PrinterControl::plate_cleared(ControlMethod::Later later) {
  if (has_unfinished_job()) throw ControlRefusal(fmt::format("{} is being printed", job_.name()));
  if (hold_.plate_occupant()) context_.log.info("plate", "the plate is clear");
  hold_.give_up_interrupted();
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
