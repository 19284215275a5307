#include "daemon/jobs/queue_hold.hpp"

#include <fmt/format.h>

#include <memory>
#include <system_error>
#include <utility>

#include "daemon/spool/reading_record.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Fulfils a promise at the end of a scope.
struct SetValue {
  void operator()(std::promise<void>* promise) const { promise->set_value(); }
};

void keep_on_disk(const StateRecords& records, const std::optional<std::string>& occupant,
                  const std::optional<std::string>& reason) {
  records.set_plate_occupant(occupant);
  records.set_hold(reason);
}

}  // namespace

void QueueHold::load() {
  plate_occupant_ = spool_.records().plate_occupant();
  reason_ = spool_.records().hold();
}

std::vector<EndedJob> QueueHold::adopt_left_jobs(
    const std::function<bool(const JobFiles&)>& ended_in_reading) {
  std::vector<EndedJob> left;
  for (const JobFiles& files : spool_.interrupted()) {
    PrintEnd end{PrintOutcome::Failed, std::string(kEndedAProcess)};
    // The print had not begun.
    if (plate_occupant_ != files.name && ended_in_reading(files)) {
      unfiled_.add_left(files, end);
      context_.log.error("refused", fmt::format("{}: {}", printable(files.name), kEndedAProcess),
                         job_fields(files.name));
    } else {
      end = adopt(files, recorded_end(spool_, files.name));
    }
    end.job = files.name;
    left.push_back(ended_job(end));
  }
  // If nothing is left in printing/, the print in the last record is filed.
  if (unfiled_.empty())
    spool_.records().forget_end_of_print();
  else
    keep_now();
  return left;
}

PrintEnd QueueHold::adopt(const JobFiles& files, const std::optional<PrintEnd>& end) {
  constexpr const char* kInterrupted =
      "was interrupted: the power was cut, or contourd was killed or crashed";
  const PrintEnd ended =
      end.value_or(PrintEnd{PrintOutcome::Failed, std::string("the print ") + kInterrupted});
  unfiled_.add_left(files, end);
  const std::string how =
      end ? fmt::format("contourd did not file this print, which was {}", name_of(end->outcome))
          : "contourd did not end this print";
  context_.log.error("interrupted",
                     fmt::format("{}: {} (power cut, crash or kill)", printable(files.name), how),
                     job_fields(files.name));
  if (!end) plate_occupant_ = files.name;
  if (reason_ || ended.outcome != PrintOutcome::Failed) return ended;
  reason_ = end ? fmt::format("{} failed: {}", files.name, end->reason)
                : fmt::format("{} {}", files.name, kInterrupted);
  return ended;
}

void QueueHold::hold(const std::string& why) {
  if (reason_) return;
  reason_ = why;
  context_.log.warning("held", sentence());
  keep();
}

void QueueHold::release() {
  if (!reason_) return;
  reason_.reset();
  context_.log.info("held", "the queue continues: a user has released it");
  keep();
}

std::string QueueHold::sentence() const {
  if (!reason_) return "";
  const bool plate_too = context_.config.wait_for_plate_cleared && plate_occupant_;
  return fmt::format("the queue is held: {}; check the printer{}, then run \"contourctl {}\"",
                     printable(*reason_), plate_too ? " and clear the plate" : "",
                     plate_too ? "plate-cleared" : "resume");
}

void QueueHold::set_plate_occupant(const std::optional<std::string>& job, Saved saved) {
  plate_occupant_ = job;
  keep(std::move(saved));
}

void QueueHold::add_unfiled(const JobFiles& files, const PrintEnd& end) {
  unfiled_.add_known(files, end);
  keep();
}

std::string QueueHold::reason_to_wait() const {
  if (reason_) return sentence();
  if (!unfiled_.empty())
    return fmt::format("{} is not filed yet{}{}", unfiled_.last(), failed() ? ": " : "", trouble_);
  if (context_.config.wait_for_plate_cleared && plate_occupant_) {
    return fmt::format("the plate holds {}; run \"contourctl plate-cleared\" when it is clear",
                       *plate_occupant_);
  }
  return "";
}

void QueueHold::retry() {
  if (failed() && !saving()) keep();
}

void QueueHold::keep_now() {
  JobFilingRun filing = unfiled_.begin_filing();
  std::string trouble;
  try {
    keep_on_disk(spool_.records(), plate_occupant_, reason_);
    filing.run(spool_);
  } catch (const std::system_error& error) {
    trouble = error.what();
  }
  kept(filing, trouble);
}

void QueueHold::keep(Saved saved) {
  ++attempts_;
  const auto filing = std::make_shared<JobFilingRun>(unfiled_.begin_filing());
  const auto end = std::make_shared<std::promise<void>>();
  last_attempt_ = end->get_future().share();
  spool_.keep(
      [&spool = spool_, occupant = plate_occupant_, reason = reason_, filing,
       end](const StateRecords& records) {
        // Lets those who wait for the attempt go on, even if the disk refuses the records.
        const std::unique_ptr<std::promise<void>, SetValue> ending(end.get());
        keep_on_disk(records, occupant, reason);
        // Filed last: as long as the files are in printing/, the next start can derive what the records say.
        filing->run(spool);
      },
      [this, filing, saved = std::move(saved)](const std::string& trouble) {
        --attempts_;
        kept(*filing, trouble);
        if (saved) saved(trouble);
      });
}

void QueueHold::kept(const JobFilingRun& filing, const std::string& trouble) {
  unfiled_.end_filing(filing);
  // The trouble of an earlier attempt stays as long as the job that it kept from being filed.
  const bool filed_all = unfiled_.empty() || !filing.empty();
  if (trouble.empty() && !filed_all) return use_.hold_changed();
  if (std::exchange(trouble_, trouble) != trouble && failed()) {
    context_.log.error(
        "spool", fmt::format("cannot save the state for the next start; will retry: {}", printable(trouble)));
    unfiled_.log_that_they_stay();
  }
  use_.hold_changed();
}

}  // namespace contourd
