#include "daemon/jobs/record_keeper.hpp"

namespace contourd {

void RecordKeeper::keep(const Lines& lines) {
  wanted_ = lines;
  keep_now();
}

void RecordKeeper::keep_now() {
  if (keeping_ || wanted_ == kept_) return;
  keeping_ = true;
  keep_(wanted_, [this, lines = wanted_](const std::string& trouble) {
    keeping_ = false;
    // What was not taken is tried with the next change: it counts when contourd starts again.
    kept_ = lines;
    if (trouble_ != trouble && !trouble.empty()) failed_(trouble);
    trouble_ = trouble;
    keep_now();
  });
}

}  // namespace contourd
