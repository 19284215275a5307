// What contourctl submit tells of models before it queues them: time, resin and warnings.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ctl/submit/spool_printer.hpp"

namespace contourd::ctl {

struct OutlookQuestion {
  const std::vector<std::filesystem::path>& models;
  const std::string& ticket;  // as text; empty when there is none
  const SpoolPrinter& printer;
};

struct ModelOutlook {
  std::vector<std::string> lines;  // for a person
  nlohmann::ordered_json json;
  bool warns = false;
};

// One for each model. Takes some seconds for all of their layers together, not longer: what is not known by
// then is told as not known.
[[nodiscard]] std::vector<ModelOutlook> outlooks_of(const OutlookQuestion& question);

// Whether these are to be queued: asked at a terminal where one warns. Elsewhere they are.
[[nodiscard]] bool agreed_to(const std::vector<ModelOutlook>& outlooks);

}  // namespace contourd::ctl
