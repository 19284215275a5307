#include "daemon/jobs/job_scheduler.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <utility>

#include "daemon/spool/job_moves.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// Time until a failed disk operation is retried.
constexpr Duration kRetryInterval = 30s;
// Time until an unusable resin profile is read again; shorter, because a user may be fixing it right now.
constexpr Duration kProfileInterval = 5s;

}  // namespace

void JobScheduler::run_soon() {
  timer_ = context_.loop.at(std::chrono::steady_clock::now(), "the queue", [this] { run(); });
}

void JobScheduler::run_later(Duration wait) {
  timer_ = context_.loop.at(std::chrono::steady_clock::now() + wait, "the queue's timer", [this] { run(); });
}

void JobScheduler::retry_later(Duration wait) {
  timer_ = context_.loop.at(std::chrono::steady_clock::now() + wait, "the queue's timer", [this] {
    queue_.check_postponed();
    run();
  });
}

void JobScheduler::run() {
  try {
    // A failed save is not tried again at once.
    if (!std::exchange(hold_just_changed_, false)) hold_.retry();
    if (hold_.failed()) run_later(kRetryInterval);
    take_what_is_due();
  } catch (const std::system_error& error) {
    // The spool's disk is gone or full; the queue waits for it.
    const std::string trouble = fmt::format("the spool cannot be used: {}", printable(error.what()));
    if (std::exchange(waiting_for_, trouble) != trouble) context_.log.error("spool", trouble);
    retry_later(kRetryInterval);
  }
}

void JobScheduler::hold_changed() {
  hold_just_changed_ = true;
  run_soon();
}

void JobScheduler::take_what_is_due() {
  if (stopped_) return;
  const bool has_job = use_.has_job();
  const std::string reason = has_job || queue_.empty() ? "" : reason_to_wait();
  // The reason of a job that waits for confirmation is already logged.
  if (std::exchange(waiting_for_, reason) != reason && !reason.empty() && queue_.has_first()) {
    context_.log.info("waiting",
                      fmt::format("{} waits: {}", printable(queue_.next().file), printable(reason)));
  }
  if (queue_.empty()) return;
  if (!has_job && reason.empty()) return claim_next();
  if (queue_.has_first()) queue_.next().waited = true;
  // Polled, because no event reports free disk space or a fixed profile.
  if (!reason.empty()) retry_later(waits_for_profile() ? kProfileInterval : kRetryInterval);
  queue_.check_next();
}

std::string JobScheduler::reason_to_wait() const {
  if (use_.controlled_by_hand()) return "the printer is controlled by hand; \"contourctl stop\" ends that";
  if (std::string not_ready = context_.machine.why_not_ready(); !not_ready.empty()) return not_ready;
  if (std::string reason = hold_.reason_to_wait(); !reason.empty()) return reason;
  if (std::string trouble = spool_.trouble(); !trouble.empty()) return trouble;
  const std::uintmax_t free = spool_.free_bytes();
  const std::uintmax_t needed = context_.config.min_free_disk_bytes;
  if (free < needed) {
    return fmt::format("the spool's disk has {} MB free, {} MB are needed", free / 1'000'000,
                       needed / 1'000'000);
  }
  if (!queue_.has_first()) return question_about(queue_.jobs().front().file, queue_.jobs().front().asks);
  return queue_.first_unanalyzed();
}

bool JobScheduler::waits_for_profile() const {
  return queue_.has_first() && queue_.next().analysis == WaitingJob::Analysis::Blocked;
}

void JobScheduler::claim_next() {
  // The end of the check, of the rejection or of the claim leads here again.
  if (!queue_.first_may_begin() || claiming_) return;
  WaitingJob& job = queue_.next();
  // The file is being rewritten; it arrives again when it is complete.
  if (spool_.is_unfinished(job.file)) {
    spool_.wait_for(queue_.take_first().file);
    return run_soon();
  }
  std::optional<JobSettings> settings;
  try {
    settings = settings_of(job);
    if (is_checked_first(job, settings)) return queue_.check_next();
    const JobFiles there = spool_.files_of(Spool::Folder::Incoming, job.file);
    if (spool_.is_waiting(job.file) && !queue_.questions().knows(job.analyzed, there, settings)) {
      job.check_again();
      return run_soon();
    }
  } catch (const ProfileTrouble& trouble) {
    return wait_for_profile(job, trouble.sentence());
  }
  claiming_ = TakenJob{queue_.take_first(), std::move(settings)};
  claims_.claim(claiming_->job.file, [this](const Claim& claim) { claimed(claim); });
}

void JobScheduler::claimed(const Claim& claim) {
  if (claim.files)
    begin(*std::exchange(claiming_, std::nullopt), *claim.files);
  else
    not_claimed(claim);
  use_.may_stop();
}

bool JobScheduler::is_checked_first(const WaitingJob& job, const std::optional<JobSettings>& settings) const {
  const bool supported = settings && settings->supports == SupportPolicy::Auto;
  return supported && job.check == WaitingJob::Check::Wanted && spool_.is_waiting(job.file);
}

std::optional<JobSettings> JobScheduler::settings_of(const WaitingJob& job) const {
  try {
    return read_settings(spool_.files_of(Spool::Folder::Incoming, job.file), context_.config);
  } catch (const ProfileTrouble& trouble) {
    // The ticket is not at fault if the profile existed when the job was checked.
    const bool known = job.check == WaitingJob::Check::Passed;
    if (known || trouble.fault() == ProfileTrouble::Fault::Profile) throw;
    return std::nullopt;
  } catch (const JobRefused&) {
    return std::nullopt;
  }
}

void JobScheduler::begin(TakenJob taken, const JobFiles& files) {
  const WaitingJob& job = taken.job;
  std::vector<std::string> accepted;
  for (const std::string_view finding : {kUnheldPlaces, kWideGaps})
    if (queue_.questions().has_accepted(job.analyzed, std::string(finding))) accepted.emplace_back(finding);
  queue_.begun(job);
  use_.begin({.files = files,
              .settings = std::move(taken.settings),
              .turn_came = job.waited ? std::chrono::steady_clock::now() : job.arrived,
              .accepted = std::move(accepted)});
  // The next job is analyzed during the print.
  if (queue_.questions().wanted()) run_soon();
}

// Keeps the job waiting and polls the profile, because no event reports that a user has fixed it.
void JobScheduler::wait_for_profile(WaitingJob& job, const std::string& why) {
  const std::string trouble = fmt::format("{}; the queue continues when the profile is fixed", why);
  if (std::exchange(job.trouble, trouble) != trouble)
    context_.log.error("profile", fmt::format("{} waits: {}", printable(job.file), printable(trouble)),
                       file_fields(job.file));
  waiting_for_ = trouble;
  job.waited = true;
  job.check = WaitingJob::Check::Passed;  // as far as it can be checked now
  run_later(kProfileInterval);
  queue_.check_next();
}

// Retries until the job is removed, because no event reports that the disk works again.
void JobScheduler::not_claimed(const Claim& claim) {
  const std::string file = claiming_->job.file;
  if (spool_.is_waiting(file) && is_immovable(claim.code))
    return spool_.begin_with_copy(
        file, [this, why = claim.code.message()](const Spool::Copy& copy) { copied(copy, why); });
  WaitingJob job = std::exchange(claiming_, std::nullopt)->job;
  if (!spool_.is_waiting(file)) {
    queue_.withdrawn(file);
    log_withdrawn(context_.log, file);
    return run_soon();
  }
  note_trouble(job, fmt::format("{} cannot be claimed: {}", printable(file), printable(claim.trouble)));
  queue_.put_first(std::move(job));
  retry_later(kRetryInterval);
}

void JobScheduler::note_trouble(WaitingJob& job, const std::string& trouble) {
  if (std::exchange(job.trouble, trouble) != trouble)
    context_.log.error("claim", trouble, file_fields(job.file));
  waiting_for_ = trouble;
  job.waited = true;
}

void JobScheduler::copied(const Spool::Copy& copy, const std::string& why) {
  TakenJob taken = *std::exchange(claiming_, std::nullopt);
  if (copy.job) {
    const std::string& file = taken.job.file;
    context_.log.warning(
        "copied",
        fmt::format("{}: printing a copy, because it cannot be moved: {}{}", printable(file), why,
                    copy.job->original.empty() ? "" : "; the original in incoming may be deleted"),
        file_fields(file));
    begin(std::move(taken), *copy.job);
  } else if (!copy.unreadable.empty()) {
    queue_.put_first(std::move(taken.job));
    queue_.refuse_first(refusal_text(copy.unreadable));
  } else {
    not_copied(std::move(taken.job), copy.trouble);
  }
  use_.may_stop();
}

void JobScheduler::not_copied(WaitingJob job, const std::string& trouble) {
  note_trouble(job, fmt::format("{} cannot be copied: {}", printable(job.file), printable(trouble)));
  // A problem with this job alone must not keep the others waiting.
  queue_.put_last(std::move(job));
  if (queue_.next().trouble.empty())
    run_soon();
  else
    retry_later(kRetryInterval);
}

}  // namespace contourd
