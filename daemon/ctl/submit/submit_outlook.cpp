#include "daemon/ctl/submit/submit_outlook.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <stop_token>
#include <system_error>
#include <utility>

#include "core/analysis/print_analysis.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/prepare/job_memory.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/prepare/resin_temperature.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

// Time limit for the layers of all models together. contourd itself has no such limit.
constexpr Duration kLongestLook = 10s;
// Larger files are queued without a forecast.
constexpr std::uintmax_t kLargestRead = 100'000'000;

// Makes the forecasts of models for one printer, until a deadline.
class Look {
 public:
  explicit Look(const OutlookQuestion& question) : question_(question), printer_(question.printer) {}

  ModelOutlook at(const fs::path& model) {
    outlook_ = {{}, Json::object(), false, ""};
    for (const char* key : {"layers", "print_time_s", "resin_ml", "resin", "supports"})
      outlook_.json[key] = nullptr;
    outlook_.json["warnings"] = Json::array();
    outlook_.json["asks"] = Json::array();
    outlook_.json["unknown"] = nullptr;
    try {
      look_at(model);
    } catch (const JobTooLarge& refusal) {
      // contourd counts the memory when the job's turn comes, and may then have more or less of it.
      undecided(model, refusal.what());
    } catch (const ProfileTrouble& trouble) {
      // With a broken profile, contourd keeps a job waiting.
      if (trouble.fault() == ProfileTrouble::Fault::Profile)
        undecided(model, trouble.sentence());
      else
        outlook_.refusal = trouble.what();
    } catch (const JobRefused& refusal) {
      outlook_.refusal = refusal.what();
    } catch (const std::exception& error) {
      unknown(model, error.what());
    }
    return std::move(outlook_);
  }

 private:
  void look_at(const fs::path& model) {
    if (!printer_.config) return unknown(model, printer_.unknown);
    std::error_code gone;
    if (const std::uintmax_t bytes = fs::file_size(model, gone); !gone && bytes > kLargestRead)
      return unknown(model, fmt::format("a file of {} MB is too large for a forecast", bytes / 1'000'000));
    JobTicket ticket =
        question_.ticket.empty() ? JobTicket{} : parse_job_ticket(question_.ticket, "the ticket");
    PreparedJob job =
        prepare_job({model_stem(model.filename().string()), model, std::nullopt},
                    settings_by(std::move(ticket), "the ticket", *printer_.config), *printer_.config);
    follow_temperature(job, *printer_.config);
    const std::vector<Duration> durations = layer_durations(job.plan, *printer_.config);
    const Duration time = forecast_of(job.plan, *printer_.config).time.total();
    outlook_.json["layers"] = job.summary.layers.count;
    outlook_.json["print_time_s"] = std::chrono::duration<double>(time).count();
    outlook_.json["resin"] = job.summary.resin.name;
    if (job.summary.supports)
      outlook_.json["supports"] = supports_summary_json(counts_of(*job.summary.supports));
    const auto layers = static_cast<std::uint64_t>(job.summary.layers.count);
    const std::string text = fmt::format("{} in {}", count_of(layers, "layer", "layers"), readable(time));
    const std::optional<PreprintAnalysis> analysis = analysis_within(job, durations);
    if (!analysis) {
      add_line(model,
               fmt::format("{}, {}; amount of resin unknown", text, printable(job.summary.resin.name)));
      for (const std::string& warning : job.summary.warnings)
        warn(warning);
      outlook_.json["unknown"] =
          fmt::format("not all layers were analyzed within {:.0f} s", milliseconds(kLongestLook) / 1000);
      return note(outlook_.json["unknown"].get<std::string>());
    }
    outlook_.json["resin_ml"] = analysis->resin_ml.value();
    add_line(model, fmt::format("{}, {:.2f} ml of {}", text, analysis->resin_ml.value(),
                                printable(job.summary.resin.name)));
    if (job.summary.supports && counts_of(*job.summary.supports).any())
      note("supports: " + supports_line(counts_of(*job.summary.supports)));
    for (const std::string& warning : analysis->warnings)
      warn(warning);
    const std::vector<std::string> asked = asked_findings(*analysis, *printer_.config);
    outlook_.json["asks"] = asked;
    if (!asked.empty())
      note(fmt::format("the printer will ask before it prints this: {}", findings_text(asked)));
  }

  // Returns nullopt if the deadline passed before all layers were analyzed.
  [[nodiscard]] std::optional<PreprintAnalysis> analysis_within(
      const PreparedJob& job, const std::vector<Duration>& durations) const {
    std::stop_source stop;
    // Called for each layer, before its mask is made.
    const auto duration_of = [&](std::int32_t layer) {
      if (Clock::now() > deadline_) stop.request_stop();
      return durations[static_cast<std::size_t>(layer)];
    };
    const auto findings = analyze_print(*job.analysis_engine, job.display, job.plan.expected_layers,
                                        duration_of, stop.get_token(), job.analysis);
    if (!findings || stop.stop_requested()) return std::nullopt;
    return preprint_analysis_of(job.summary, *findings, *printer_.config);
  }

  void add_line(const fs::path& model, const std::string& text) {
    outlook_.lines.push_back(printable(model.string()) + ": " + text);
  }
  void warn(const std::string& warning) {
    outlook_.warns = true;
    outlook_.json["warnings"].push_back(warning);
    outlook_.lines.push_back("  warning: " + printable(warning));
  }
  void note(const std::string& text) { outlook_.lines.push_back("  " + text); }
  void undecided(const fs::path& model, const std::string& why) {
    add_line(model, "time and resin unknown");
    warn(fmt::format("contourd cannot print it at present: {}", why));
  }
  void unknown(const fs::path& model, const std::string& why) {
    outlook_.json["unknown"] = why;
    add_line(model, "time and resin unknown: " + printable(why));
  }

  const OutlookQuestion& question_;
  const SpoolPrinter& printer_;
  const Clock::time_point deadline_ = Clock::now() + kLongestLook;
  ModelOutlook outlook_;
};

}  // namespace

SpoolPrinter printer_of(const fs::path& spool, const std::optional<fs::path>& given) {
  if (given) return {load_printer_config(*given, Places::Elsewhere), ""};
  std::string why = fmt::format("{} is for another spool", kDefaultConfig);
  try {
    PrinterConfig config = load_printer_config(kDefaultConfig, Places::Elsewhere);
    std::error_code ignored;
    if (fs::equivalent(config.spool_folder, spool, ignored)) return {std::move(config), ""};
  } catch (const ConfigError& error) {
    why = error.violations().empty() ? "its configuration is not valid"
                                     : ConfigError({error.violations().front()}).what();
  } catch (const std::exception& error) {
    why = error.what();
  }
  return {std::nullopt,
          fmt::format("the printer is unknown: {}; specify it by --printer FILE", printable(why))};
}

std::vector<ModelOutlook> outlooks_of(const OutlookQuestion& question) {
  Look look(question);
  std::vector<ModelOutlook> outlooks;
  for (const fs::path& model : question.models)
    outlooks.push_back(look.at(model));
  return outlooks;
}

bool agreed_to(const std::vector<ModelOutlook>& outlooks) {
  const bool warns = std::ranges::any_of(outlooks, &ModelOutlook::warns);
  if (!warns || ::isatty(STDIN_FILENO) == 0 || ::isatty(STDOUT_FILENO) == 0) return true;
  fmt::print("Queue {} anyway? [Y/n] ", outlooks.size() == 1 ? "it" : "them");
  std::fflush(stdout);
  std::string answer;
  if (!std::getline(std::cin, answer)) {
    fmt::print("\n");
    return false;
  }
  return answer.empty() || answer == "y" || answer == "Y" || answer == "yes";
}

}  // namespace contourd::ctl
