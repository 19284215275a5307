#include "daemon/history/vat.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

namespace contourd {

void Vat::load() {
  const std::optional<std::string> text = spool_.records().vat();
  double ml = 0;
  if (!text) return;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), ml);
  if (error == std::errc{} && end == text->data() + text->size() && std::isfinite(ml) && ml >= 0)
    ml_ = recorded_ml_ = ml;
}

void Vat::fill(double ml, std::function<void(const std::string& trouble)> saved) {
  ml_ = ml;
  keep(std::move(saved));
}

std::string Vat::use(double ml) {
  if (!ml_) return "";
  const double before = *ml_;
  ml_ = std::max(before - ml, 0.0);
  if (std::abs(*ml_ - recorded_ml_) >= kRecordedMl) save();
  const bool falls_low = before >= kLowMl && *ml_ < kLowMl;
  const bool falls_empty = before > 0 && *ml_ == 0;
  if (!falls_low && !falls_empty) return "";
  return fmt::format(
      "the vat holds about {:.0f} ml of resin: fill it, run \"contourctl vat filled ML\", then \"contourctl "
      "resume\"",
      *ml_);
}

void Vat::save() {
  if (ml_ && *ml_ != recorded_ml_) keep([](const std::string&) {});
}

void Vat::keep(std::function<void(const std::string& trouble)> saved) {
  recorded_ml_ = ml_.value_or(0);
  spool_.keep(
      [text = fmt::format("{:.3f}", recorded_ml_)](const StateRecords& records) { records.set_vat(text); },
      std::move(saved));
}

}  // namespace contourd
