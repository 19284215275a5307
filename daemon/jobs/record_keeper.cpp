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
    // A failed write is repeated with the next change; the record matters only when contourd starts again.
    kept_ = lines;
    if (trouble_ != trouble && !trouble.empty()) failed_(trouble);
    trouble_ = trouble;
    keep_now();
  });
}

}  // namespace contourd
