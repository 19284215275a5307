// The forecast that contourctl submit prints before it queues models: time, resin and warnings, and the
// printer for which it is made.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/printer_config.hpp"

namespace contourd::ctl {

struct SpoolPrinter {
  std::optional<PrinterConfig> config;
  std::string unknown;  // if there is none: the reason
};

// Finds the printer that prints from a spool, if this program's user can read its configuration. Loads the
// configuration `given`; without it the installed configuration, if it names this spool. Throws ConfigError
// if `given` is not valid.
[[nodiscard]] SpoolPrinter printer_of(const std::filesystem::path& spool,
                                      const std::optional<std::filesystem::path>& given);

struct OutlookQuestion {
  const std::vector<std::filesystem::path>& models;
  const std::string& ticket;  // as text; empty: none
  const SpoolPrinter& printer;
};

struct ModelOutlook {
  std::vector<std::string> lines;  // for a person
  nlohmann::ordered_json json;
  bool warns = false;
  std::string refusal;  // the reason for which contourd would refuse the model; empty: none is known
};

// Returns a forecast for each model. Analyzes the layers of all models for at most ten seconds; facts that
// are not known by then are reported as unknown.
[[nodiscard]] std::vector<ModelOutlook> outlooks_of(const OutlookQuestion& question);

// Asks at a terminal whether models with warnings are to be queued. Returns true without asking if there is
// no warning or no terminal.
[[nodiscard]] bool agreed_to(const std::vector<ModelOutlook>& outlooks);

}  // namespace contourd::ctl
