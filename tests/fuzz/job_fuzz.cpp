// Fuzz target: a job of small models through all of its preparation. The bytes choose the models and the
// ticket's keys and values, each within its schema, or are the ticket themselves (first byte above 239). The
// job is refused in one sentence, or its layers can be analyzed. No ticket breaks a contract.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "daemon/json/schema_text.hpp"
#include "daemon/prepare/job_outlook.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/print_job.hpp"
#include "tests/fuzz/told.hpp"
#include "tests/models/damage.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::fuzz {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::array<const char*, 9> kModels{"box.stl",    "ball.stl",  "cracked.stl",
                                             "bridge.stl", "shell.stl", "needle.stl",
                                             "tiny.stl",   "far.stl",   "soup.stl"};

models::Facets facets_of(std::string_view name) {
  const models::Facets box = models::box({0, 0, 0}, {3, 2, 1});
  if (name == "ball.stl") return models::sphere(1.5, 6);
  if (name == "bridge.stl")
    return models::together(
        {box, models::box({0.5, 0.5, 0.5}, {1, 1, 3}), models::box({0, 0, 3}, {8, 1, 3.2F})});
  if (name == "shell.stl")
    return models::together(box, models::inverted(models::box({1, 0.5, 0.2F}, {2, 1.5, 0.8F})));
  if (name == "needle.stl") return models::box({0, 0, 0}, {0.01F, 0.01F, 6});
  if (name == "tiny.stl") return models::box({0, 0, 0}, {0.002F, 0.001F, 0.003F});
  models::Dice dice(1);
  if (name == "soup.stl") return models::soup(8, 2, dice);
  models::Facets facets = name == "cracked.stl" ? models::sphere(1.5, 6) : box;
  if (name == "cracked.stl") models::drop_facets(facets, 0.05, dice);
  if (name == "far.stl") models::translate(facets, 0, 4e6F, 0);
  return facets;
}

// A small printer with the shipped resin, and the models in a plate's folder.
class Workshop {
 public:
  Workshop() : printer(load_printer_config(fs::path(CONTOURD_CONFIG_DIR) / "simulated.json")) {
    printer.display_width = Pixels{96};
    printer.display_height = Pixels{64};
    printer.pixel_pitch = Micrometers{200};
    printer.travel = Nanometers{26'000'000};
    fs::create_directory(plate());
    for (const char* name : kModels)
      models::write_binary_stl(plate() / name, facets_of(name));
  }

  [[nodiscard]] fs::path plate() const { return folder.path() / "plate"; }

  testing::TemporaryFolder folder;
  PrinterConfig printer;
};

class Choices {
 public:
  explicit Choices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  // Returns the next byte, 0 at the end.
  std::uint8_t next() {
    if (bytes_.empty()) return 0;
    const std::uint8_t byte = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return byte;
  }
  template <typename List>
  auto one_of(const List& list) {
    return list[next() % std::size(list)];
  }
  [[nodiscard]] std::span<const std::uint8_t> rest() const { return bytes_; }

 private:
  std::span<const std::uint8_t> bytes_;
};

// Chooses values that a schema allows; rules across keys may still refuse them.
class TicketMaker {
 public:
  explicit TicketMaker(Choices& choices) : choices_(choices) {}

  Json ticket(bool plate) { return value(plate ? plate_ : ticket_); }

 private:
  Json value(const Json& given) {
    const std::string reference = given.value("$ref", "");
    const Json& schema =
        reference.empty() ? given : ticket_.at(Json::json_pointer(reference.substr(reference.find('#') + 1)));
    const Json& type = schema.at("type");
    const std::string chosen = type.is_array() ? choices_.one_of(type) : type;
    if (chosen == "object") return object(schema);
    if (chosen == "array") return array(schema);
    if (chosen == "string") return text(schema);
    if (chosen == "boolean") return choices_.next() % 2 != 0;
    const double number = number_of(schema);
    return chosen == "integer" ? Json(static_cast<int>(number)) : Json(number);
  }

  Json object(const Json& schema) {
    Json made = Json::object();
    const Json required = schema.value("required", Json::array());
    for (const auto& [key, each] : schema.at("properties").items()) {
      const bool needed = std::ranges::find(required, Json(key)) != required.end();
      // A quarter of the keys: fewer tickets have keys that exclude each other.
      if (key != "$schema" && (needed || choices_.next() % 4 == 1))
        made[key] = key == "file"    ? Json(choices_.one_of(kModels))
                    : key == "resin" ? Json("standard")
                                     : value(each);
    }
    return made;
  }

  Json array(const Json& schema) {
    Json made = Json::array();
    const int items = 1 + choices_.next() % 3;
    while (made.size() < static_cast<std::size_t>(items))
      made.push_back(value(schema.at("items")));
    return made;
  }

  Json text(const Json& schema) {
    if (schema.contains("enum")) return choices_.one_of(schema.at("enum"));
    constexpr std::array words{"auto", "off", "fast", "clean", "safe"};
    return choices_.one_of(words);
  }

  double number_of(const Json& schema) {
    const double least = schema.at("minimum"), most = schema.at("maximum");
    const double part = choices_.next() / 255.0;
    switch (choices_.next() % 6) {
      case 0:
        return least;
      case 1:
        return most;
      case 2:
        return std::clamp(0.0, least, most);
      case 3:
        return least + part * (most - least);
      case 4:
        return std::clamp(8 * part - 4, least, most);
      default:
        return std::clamp((part < 0.5 ? -1 : 1) * std::pow(10.0, 16 * part - 8), least, most);
    }
  }

  Choices& choices_;
  const Json ticket_ = Json::parse(ticket_schema_text), plate_ = Json::parse(plate_schema_text);
};

// Returns the job's files, with its ticket written.
JobFiles files_by(Choices& choices, const Workshop& workshop) {
  constexpr std::uint8_t kText = 240;
  const std::uint8_t kind = choices.next();
  const bool plate = kind % 2 != 0;
  const char* const model = plate ? "" : choices.one_of(kModels);
  const auto rest = choices.rest();
  const std::string text =
      kind >= kText ? std::string(rest.begin(), rest.end()) : TicketMaker(choices).ticket(plate).dump();
  if (plate) {
    (void)workshop.folder.write("plate/plate.json", text);
    return {"fuzzed", workshop.plate(), std::nullopt, true};
  }
  return {"fuzzed", workshop.plate() / model, workshop.folder.write("fuzzed.json", text)};
}

void check(const PreparedJob& job, const JobFiles& files, const PrinterConfig& printer) {
  demand(!job.plan.expected_layers.empty(), "a job without layers");
  demand(std::isfinite(job.summary.height_mm) && job.summary.height_mm > 0, "a job without height");
  for (const std::string& warning : job.summary.warnings)
    demand_sentence(warning);
  demand(outlook_of(job, files, printer).forecast.time.total() > Duration{0}, "a print takes no time");
  demand_sentence(describe_settings(job.summary));
  constexpr std::size_t kMostLayers = 150;
  if (job.plan.expected_layers.size() > kMostLayers) return;
  const auto analysis = analyze_before_print(job, printer, {});
  demand(analysis.has_value(), "an analysis without a result");
  for (const std::string& warning : analysis->warnings)
    demand_sentence(warning);
}

}  // namespace
}  // namespace contourd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace contourd;
  static fuzz::Workshop workshop;
  fuzz::Choices choices({data, size});
  const std::uint8_t machine = choices.next();
  PrinterConfig& printer = workshop.printer;
  printer.anti_aliasing = machine % 2 == 0;
  printer.mirror_x = machine / 2 % 2 != 0;
  printer.supports = machine / 4 % 2 != 0 ? SupportPolicy::Auto : SupportPolicy::Off;
  const JobFiles files = fuzz::files_by(choices, workshop);
  try {
    fuzz::check(prepare_job(files, read_settings(files, printer), printer), files, printer);
  } catch (const JobRefused& refused) {
    fuzz::demand_sentence(refused.what());
  }
  return 0;
}
