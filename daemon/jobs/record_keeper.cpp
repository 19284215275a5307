#include "daemon/jobs/record_keeper.hpp"

#include "daemon/system/readable.hpp"

namespace contourd {

void RecordKeeper::keep(const Lines& lines) {
  wanted_ = lines;
  keep_now();
}

void RecordKeeper::keep_now() {
  if (keeping_ || wanted_ == kept_) return;
  keeping_ = true;
  checks_.save(record_, wanted_, [this, lines = wanted_](const std::string& trouble) {
    keeping_ = false;
    // A failed write is repeated with the next change; the record matters only when contourd starts again.
    kept_ = lines;
    if (std::exchange(trouble_, trouble) != trouble && !trouble.empty()) note_trouble(trouble);
    keep_now();
  });
}

void RecordKeeper::note_trouble(const std::string& trouble) {
  if (record_ == JobChecks::Record::Order)
    log_.warning("queue",
                 "cannot save the order of the queue; a restart will lose it: " + printable(trouble));
  else
    log_.warning("accepted", "cannot save what was accepted; it must be confirmed again after a restart: " +
                                 printable(trouble));
}

}  // namespace contourd
