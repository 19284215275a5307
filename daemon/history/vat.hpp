// The resin in the vat: what a user said when filling it, less what prints have cured since. Survives a
// restart. Event loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "daemon/spool/spool.hpp"

namespace contourd {

class Vat {
 public:
  // A print pauses when the vat falls below this, and once more when it is empty by contourd's account.
  static constexpr double kLowMl = 10;
  // The resin that prints have cured is recorded in steps of this size, and at the end of a print.
  static constexpr double kRecordedMl = 1;

  // The spool must outlive the vat.
  explicit Vat(Spool& spool) : spool_(spool) {}

  // Restores what the last process recorded. Blocks.
  void load();
  // Returns the resin in the vat; nullopt if no user has told.
  [[nodiscard]] std::optional<double> ml() const { return ml_; }
  // Takes the user's word. `saved` is called from the loop, with the error of the disk or an empty text.
  void fill(double ml, std::function<void(const std::string& trouble)> saved);
  // Subtracts resin that was cured. Returns a sentence if that leaves too little to go on unattended; else an
  // empty text.
  [[nodiscard]] std::string use(double ml);
  // Records what is left.
  void save();

 private:
  void keep(std::function<void(const std::string& trouble)> saved);

  Spool& spool_;
  std::optional<double> ml_;
  double recorded_ml_ = 0;
};

}  // namespace contourd
