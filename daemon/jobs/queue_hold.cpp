#include "daemon/jobs/queue_hold.hpp"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <set>
#include <system_error>
#include <utility>

#include "daemon/progress/interrupted_print.hpp"
#include "daemon/spool/reading_record.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Fulfils a promise at the end of a scope.
struct SetValue {
  void operator()(std::promise<void>* promise) const { promise->set_value(); }
};

// The words after the job's name in the reason of a hold.
constexpr std::string_view kWasInterrupted = " was interrupted: ";

// Writes the progress of an interrupted print, and returns why that failed; empty if it did not.
std::string write_over(const std::filesystem::path& file, const JobProgress& progress) {
  try {
    ProgressRecord record(file);
    record.go_on();
    record.write(progress);
    return "";
  } catch (const std::system_error& error) {
    return error.what();
  }
}

// Returns why the queue is held for a print whose progress is recorded and whose files are gone from
// printing/.
std::string held_without_files(const JobProgress& progress, const std::filesystem::path& printing) {
  return fmt::format(
      "{}{}{}, {}; its files are not in {}: if their disk is not mounted, mount it and restart "
      "contourd, which then can continue the print",
      progress.job, kWasInterrupted, kWhyInterrupted, describe(progress), printing.string());
}

// Returns how far the job's print was; nullptr if that is unknown.
const JobProgress* progress_of(const ProgressRecord::Found& found, const JobFiles& files) {
  return found.progress && found.progress->job == files.name ? &*found.progress : nullptr;
}

void keep_on_disk(const StateRecords& records, const std::optional<std::string>& occupant,
                  const std::optional<std::string>& reason) {
  records.set_plate_occupant(occupant);
  if (occupant) records.make_spares();
  records.set_hold(reason);
}

}  // namespace

void QueueHold::load() {
  plate_occupant_ = spool_.records().plate_occupant();
  reason_ = spool_.records().hold();
}

void QueueHold::adopt_left_jobs(const std::function<bool(const JobFiles&)>& ended_in_reading) {
  std::set<std::string> left;
  progress_ = ProgressRecord(progress_file(context_.config.spool_folder)).read();
  for (const JobFiles& files : spool_.interrupted()) {
    // The print of a job whose part is on the plate had begun: it was read to be continued.
    const bool ended = ended_in_reading(files), had_begun = plate_occupant_ == files.name;
    adopt(files, ended && !had_begun);
    if (interrupted_ && interrupted_->files.name == files.name) interrupted_->ended_reading = ended;
    left.insert(files.name);
  }
  // The last process has filed the others.
  for (const JobEndRecord::Pending& each : spool_.ends().pending())
    if (!left.contains(each.end.job)) spool_.ends().files_taken(each.end.job);
  // The files of a print that was filed after its last record are in another folder.
  const bool has_files = !progress_.progress || spool_.ends().end_of(progress_.progress->job) ||
                         SpoolFolders(context_.config.spool_folder).unused_name(progress_.progress->job) !=
                             progress_.progress->job;
  without_files_ = !has_files && has_part(progress_.progress->print);
  if (without_files_) {
    // The record stays for the start at which the files are back.
    plate_occupant_ = progress_.progress->job;
    reason_ = held_without_files(*progress_.progress, spool_.folder(Spool::Folder::Printing));
    context_.log.error("interrupted", printable(*reason_), job_fields(*plate_occupant_));
  } else if (!interrupted_) {  // a job of the same name must not be taken for the recorded one
    ProgressRecord(progress_file(context_.config.spool_folder)).end();
  }
  if (interrupted_ || without_files_ || !unfiled_.empty()) keep_now();
}

bool QueueHold::part_may_hang() const {
  return !context_.config.wait_for_plate_cleared && reason_ && plate_occupant_ &&
         reason_->starts_with(*plate_occupant_ + std::string(kWasInterrupted));
}

void QueueHold::adopt(const JobFiles& files, bool ended_in_reading) {
  JobEnd end = end_of_left(files.name, ended_in_reading);
  const bool interrupted = end.kind == JobEnd::Kind::Interrupted;
  if (!interrupted || !await_decision(files, end)) unfiled_.add_left(files, end);
  if (end.kind == JobEnd::Kind::Refused) {
    const bool failed = end.outcome == name_of(PrintOutcome::Failed);
    return context_.log.write(failed ? LogLevel::Error : LogLevel::Info, "refused",
                              fmt::format("{}: {}", printable(files.name), printable(end.reason)),
                              job_fields(files.name));
  }
  const std::string how =
      interrupted ? "contourd stopped before this print ended"
                  : fmt::format("contourd stopped before it moved the files of this print, which was {}",
                                end.outcome);
  const std::string where = !interrupted                    ? ""
                            : progress_of(progress_, files) ? ", " + describe(*progress_.progress)
                            : !progress_.trouble.empty()    ? ", and the record of its progress is damaged"
                                                            : "";
  context_.log.error("interrupted",
                     fmt::format("{}: {} (power cut, crash or kill){}", printable(files.name), how, where),
                     job_fields(files.name));
  if (interrupted) plate_occupant_ = files.name;
  // The part of an interrupted print on the plate matters more than what held the queue before.
  if ((reason_ && !interrupted) || end.outcome != name_of(PrintOutcome::Failed)) return;
  reason_ = files.name + (interrupted ? std::string(kWasInterrupted) + std::string(kWhyInterrupted) + where
                                      : " failed: " + end.reason);
}

bool QueueHold::await_decision(const JobFiles& files, JobEnd& end) {
  if (!progress_.trouble.empty())
    context_.log.error("progress", fmt::format("{}: {}", printable(files.name), printable(progress_.trouble)),
                       job_fields(files.name));
  const JobProgress* const progress = progress_of(progress_, files);
  if (progress == nullptr) return false;
  end.reason = fmt::format("{}, {}", interruption(end.key, end.job).reason, describe(*progress));
  try {
    spool_.ends().add(end);
  } catch (const std::system_error&) {
    // As in end_of_left().
  }
  if (interrupted_ || !has_part(progress->print)) return false;
  interrupted_ = {files, *progress, progress_.trouble.empty()};
  return true;
}

void QueueHold::give_up_interrupted() {
  if (!interrupted_ && !without_files_) return;
  spool_.run(
      [file = progress_file(context_.config.spool_folder)] {
        ProgressRecord(file).end();
        return true;
      },
      [](bool) {});
  without_files_ = false;
  if (!interrupted_) return;
  const JobFiles files = std::exchange(interrupted_, std::nullopt)->files;
  add_unfiled(files, spool_.ends().end_of(files.name).value_or(interruption(new_job_key(), files.name)));
}

void QueueHold::interrupted_moves(std::optional<Nanometers> distance) {
  if (!interrupted_) return;
  move_by_hand(interrupted_->progress.print, distance);
  spool_.run([file = progress_file(context_.config.spool_folder),
              progress = interrupted_->progress] { return write_over(file, progress); },
             [this](const std::string& trouble) {
               if (!trouble.empty())
                 context_.log.error("progress",
                                    "cannot record that the plate was moved by hand: " + printable(trouble));
             });
}

JobEnd QueueHold::end_of_left(const std::string& job, bool ended_in_reading) {
  if (std::optional<JobEnd> end = spool_.ends().end_of(job)) return *std::move(end);
  JobEnd end = interruption(new_job_key(), job);
  if (ended_in_reading) {
    end.reason = kEndedAProcess;
    end.kind = JobEnd::Kind::Refused;
  }
  try {
    spool_.ends().add(end);
  } catch (const std::system_error&) {
    // A full disk has no room for the record, but a rename needs none.
  }
  return end;
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
  if (interrupted_)
    return fmt::format(
        "the queue is held: {}; its part hangs on the plate: {}, \"contourctl rescue\" lifts the part out, "
        "\"contourctl plate-cleared\" gives the print up once the plate is clear",
        printable(*reason_), describe_way_on(*interrupted_, context_.machine.z_axis().homes_upwards()));
  if (part_may_hang())
    return fmt::format(
        "the queue is held: {}; its part may hang on the plate: clear the plate, then run \"contourctl "
        "plate-cleared\"",
        printable(*reason_));
  const bool plate_too = context_.config.wait_for_plate_cleared && plate_occupant_;
  return fmt::format("the queue is held: {}; check the printer{}, then run \"contourctl {}\"",
                     printable(*reason_), plate_too ? " and clear the plate" : "",
                     plate_too ? "plate-cleared" : "resume");
}

void QueueHold::set_plate_occupant(const std::optional<std::string>& job, Saved saved) {
  plate_occupant_ = job;
  keep(std::move(saved));
}

void QueueHold::add_unfiled(const JobFiles& files, const JobEnd& end) {
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
