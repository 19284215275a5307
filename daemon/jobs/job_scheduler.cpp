#include "daemon/jobs/job_scheduler.hpp"

#include <fmt/format.h>

#include <chrono>
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
  // A failed save is not tried again at once.
  if (!std::exchange(hold_just_changed_, false)) hold_.retry();
  if (hold_.failed()) run_later(kRetryInterval);
  take_what_is_due();
}

void JobScheduler::hold_changed() {
  hold_just_changed_ = true;
  run_soon();
}

void JobScheduler::take_what_is_due() {
  if (stopped_) return;
  const bool due = !use_.has_job() && !queue_.empty();
  const std::string reason = due ? reason_to_wait() : "";
  if (due && reason.empty()) return look_at_next();
  wait_because(reason);
}

void JobScheduler::wait_because(const std::string& reason) {
  // The reason of a job that waits for confirmation is already logged.
  if (std::exchange(waiting_for_, reason) != reason && !reason.empty() && queue_.has_first()) {
    context_.log.info("waiting",
                      fmt::format("{} waits: {}", printable(queue_.next().file), printable(reason)));
  }
  if (queue_.empty()) return;
  if (queue_.has_first()) queue_.next().waited = true;
  // Polled, because no event reports free disk space or a fixed profile.
  if (!reason.empty()) retry_later(waits_for_profile() ? kProfileInterval : kRetryInterval);
  queue_.check_next();
}

std::string JobScheduler::reason_to_wait() const {
  if (use_.controlled_by_hand()) return "the printer is controlled by hand; \"contourctl stop\" ends that";
  if (std::string not_ready = context_.machine.why_not_ready(); !not_ready.empty()) return not_ready;
  if (std::string force = force_at_rest(context_.machine); !force.empty()) return force;
  if (std::string reason = hold_.reason_to_wait(); !reason.empty()) return reason;
  if (!queue_.has_first()) return question_about(queue_.jobs().front().file, queue_.jobs().front().asks);
  return queue_.first_unanalyzed();
}

bool JobScheduler::waits_for_profile() const {
  return queue_.has_first() && queue_.next().analysis == WaitingJob::Analysis::Blocked;
}

void JobScheduler::look_at_next() {
  if (waiting_for_ != look_trouble_) waiting_for_.clear();
  // The end of the check, of the rejection, of the claim or of the look leads here again.
  if (!queue_.first_may_begin() || claiming_ || looking_) return;
  looking_ = true;
  claims_.look(queue_.next().file, [this, before = queue_.next()](const JobLook& look) {
    looking_ = false;
    looked_at(before, look);
  });
}

void JobScheduler::looked_at(const WaitingJob& before, const JobLook& look) {
  if (stopped_) return;
  const bool is_due = !use_.has_job() && queue_.has_first() && reason_to_wait().empty();
  // A file that arrived again meanwhile is another job.
  const bool is_same = is_due && queue_.next().file == before.file && queue_.next().arrived == before.arrived;
  if (!is_same || !queue_.first_may_begin()) return run();
  look_trouble_ = look.disk_trouble;
  if (!look_trouble_.empty()) return wait_because(look_trouble_);
  waiting_for_.clear();
  claim_next(look);
}

void JobScheduler::claim_next(const JobLook& look) {
  WaitingJob& job = queue_.next();
  // The file is being rewritten; it arrives again when it is complete.
  if (look.is_unfinished) {
    spool_.wait_for(queue_.take_first().file);
    return run_soon();
  }
  if (const std::string why = trouble_of_profile(job, look); !why.empty()) return wait_for_profile(job, why);
  // Only the preparation finds what a user has to accept. A job that has no outlook was checked when its
  // profile could not be used.
  if (job.check == WaitingJob::Check::Passed && !job.outlook) job.check_again();
  if (look.is_there && job.check == WaitingJob::Check::Wanted) return queue_.check_next();
  if (look.is_there && !queue_.questions().knows(job.analyzed, look.content, look.settings)) {
    if (job.analyzed && queue_.questions().withdraw_confirmation(*job.analyzed))
      context_.log.info(
          "changed",
          fmt::format(
              "{}: its files or the resin's profile have changed since it was accepted: it is checked "
              "again, and has to be accepted again",
              printable(job.file)),
          file_fields(job.file));
    job.check_again();
    return run_soon();
  }
  claiming_ = TakenJob{queue_.take_first(), look.settings};
  claims_.claim(claiming_->job.file, [this](const Claim& claim) { claimed(claim); });
}

void JobScheduler::claimed(const Claim& claim) {
  if (claim.files)
    begin(*std::exchange(claiming_, std::nullopt), *claim.files);
  else
    not_claimed(claim);
  use_.may_stop();
}

std::string JobScheduler::trouble_of_profile(const WaitingJob& job, const JobLook& look) {
  if (!look.profile_trouble) return "";
  // The ticket is not at fault if the profile existed when the job was checked.
  const bool known = job.check == WaitingJob::Check::Passed;
  const bool of_profile = look.profile_trouble->fault() == ProfileTrouble::Fault::Profile;
  return known || of_profile ? look.profile_trouble->sentence() : "";
}

void JobScheduler::begin(TakenJob taken, const JobFiles& files) {
  const WaitingJob& job = taken.job;
  std::vector<std::string> accepted;
  for (const std::string_view finding : kFoundByPreparation)
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
  waiting_for_ = look_trouble_ = trouble;
  job.waited = true;
  job.check = WaitingJob::Check::Passed;  // as far as it can be checked now
  run_later(kProfileInterval);
  queue_.check_next();
}

// Retries until the job is removed, because no event reports that the disk works again.
void JobScheduler::not_claimed(const Claim& claim) {
  const std::string file = claiming_->job.file;
  if (claim.is_there && is_immovable(claim.code))
    return spool_.begin_with_copy(
        file, [this, why = claim.code.message()](const Spool::Copy& copy) { copied(copy, why); });
  WaitingJob job = std::exchange(claiming_, std::nullopt)->job;
  if (!claim.is_there) {
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
  waiting_for_ = look_trouble_ = trouble;
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
