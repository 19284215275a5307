#include "daemon/jobs/print_queue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Number of times that a rewrite may interrupt the checks of a job before the job loses its place.
constexpr int kMaxInterruptions = 3;

// Returns the refusal if the job is refused for good; nullptr otherwise.
template <typename Found>
const JobRefusal* final_refusal(const Found& found) {
  const auto* const refusal = std::get_if<JobRefusal>(&found);
  return refusal != nullptr && !refusal->for_now && refusal->profile.empty() ? refusal : nullptr;
}

void log_question(const Log& log, const WaitingJob& job) {
  const std::string file = printable(job.file);
  const LogFields fields = file_fields(job.file);
  log.warning("unaccepted", fmt::format("{} waits: {}", file, question_about(job.file, job.asks)), fields);
  for (const std::string& warning : job.analyzed->analysis.warnings)
    log.warning("unaccepted", fmt::format("{}: {}", file, printable(warning)), fields);
}

}  // namespace

void WaitingJob::analyze_again() {
  analysis = Analysis::Wanted;
  analyzed.reset();
  asks.clear();
}

void WaitingJob::check_again() {
  check = Check::Wanted;
  analyze_again();
}

PrintQueue::Position PrintQueue::find(const std::string& file) {
  return std::ranges::find(jobs_, file, &WaitingJob::file);
}

void PrintQueue::arrived(const std::string& file) {
  const Position queued = find(file);
  if (queued != jobs_.end() && queued->check == WaitingJob::Check::Refused) {
    // The refused file is on its way to failed/; rejected() finds out whether this is a new one.
    queued->withdrawn = false;
    queued->seen_again = true;
    return;
  }
  WaitingJob job{.file = file, .arrived = std::chrono::steady_clock::now()};
  if (queued != jobs_.end()) {
    job.trouble = std::move(queued->trouble);  // already logged
    const bool interrupted = queued->is_looked_at();
    job.interruptions = queued->interruptions + (interrupted ? 1 : 0);
    *queued = std::move(job);
    checks_.forget(file);
    if (interrupted && queued->interruptions > kMaxInterruptions) move_to_end(queued);
  } else {
    const std::size_t place =
        order_.place_of(file, jobs_, [](const WaitingJob& each) { return std::string_view(each.file); });
    jobs_.insert(jobs_.begin() + static_cast<std::ptrdiff_t>(place), std::move(job));
    log_.info("queued", fmt::format("{}: arrived, number {} in the queue", printable(file), place + 1),
              file_fields(file));
  }
  observer_.queue_changed();
}

// Moves a job that keeps changing to the end: the others would wait for it for ever.
void PrintQueue::move_to_end(const Position& queued) {
  WaitingJob job = std::move(*queued);
  jobs_.erase(queued);
  if (job.interruptions == kMaxInterruptions + 1 && !jobs_.empty())
    log_.warning("moved",
                 fmt::format("{}: keeps changing while being read; moved to the end of the queue",
                             printable(job.file)),
                 file_fields(job.file));
  order_.remove(job.file);
  jobs_.push_back(std::move(job));
}

void PrintQueue::withdrawn(const std::string& file) {
  const Position job = find(file);
  if (job == jobs_.end()) return order_.remove(file);
  if (job->check == WaitingJob::Check::Refused) {
    // Most likely the spool has moved it to failed/; rejected() finds out.
    job->withdrawn = true;
    return;
  }
  remove_withdrawn(job);
}

void PrintQueue::remove_withdrawn(const Position& job) {
  const std::string file = job->file;
  jobs_.erase(job);
  order_.remove(file);
  checks_.forget(file);
  log_withdrawn(log_, file);
  observer_.queue_changed();
}

void PrintQueue::check_next() {
  const Position wanted = std::ranges::find(jobs_, WaitingJob::Check::Wanted, &WaitingJob::check);
  if (wanted == jobs_.end()) return analyze_next();
  wanted->check = WaitingJob::Check::Running;
  const std::uint64_t number = wanted->check_number = ++checks_begun_;
  checks_.check(wanted->file, keep_for(wanted), [this, file = wanted->file, number](const CheckedJob& found) {
    checked(file, number, found);
  });
}

// Only the next job is worth the memory of its preparation.
JobChecks::Keep PrintQueue::keep_for(const Position& job) {
  return job - jobs_.begin() == static_cast<std::ptrdiff_t>(first()) ? JobChecks::Keep::Prepared
                                                                     : JobChecks::Keep::Nothing;
}

void PrintQueue::checked(const std::string& file, std::uint64_t number, const CheckedJob& found) {
  const Position job = find(file);
  // If the job is gone or was rewritten meanwhile, the result is about another file.
  if (job != jobs_.end() && job->check == WaitingJob::Check::Running && job->check_number == number) {
    if (const auto* const refusal = final_refusal(found)) return reject(*job, refusal->reason);
    note_check(*job, found);
  }
  observer_.queue_changed();
}

// Stores the result of a check for a job that stays in the queue.
void PrintQueue::note_check(WaitingJob& job, const CheckedJob& found) {
  if (std::holds_alternative<ReadingGivenUp>(found)) {
    job.check = WaitingJob::Check::Wanted;
    return;
  }
  const auto* const refusal = std::get_if<JobRefusal>(&found);
  if (refusal != nullptr && refusal->for_now) return postpone(job, refusal->reason);
  job.check = WaitingJob::Check::Passed;
  job.postponed.clear();
  if (refusal == nullptr) {
    job.outlook = std::get<JobOutlook>(found);
    // An analysis of all layers would find this question too.
    if (job.outlook->question && !questions_.wanted()) note_question(job, *job.outlook->question);
    return;
  }
  // The profile is read again when the job's turn comes.
  log_.warning("profile", fmt::format("{}: {}", printable(job.file), printable(refusal->profile)),
               file_fields(job.file));
}

void PrintQueue::postpone(WaitingJob& job, const std::string& why) {
  job.check = WaitingJob::Check::Postponed;
  // Logged once only, because the figures in `why` change all the time.
  if (!std::exchange(job.postponed, why).empty()) return;
  log_.info("postponed",
            fmt::format("{}: will be read later, because there is not enough memory now: {}",
                        printable(job.file), why),
            file_fields(job.file));
}

void PrintQueue::check_postponed() {
  for (WaitingJob& job : jobs_) {
    if (job.check == WaitingJob::Check::Postponed) job.check = WaitingJob::Check::Wanted;
    if (job.analysis == WaitingJob::Analysis::Blocked) job.analysis = WaitingJob::Analysis::Wanted;
  }
}

// Starts the next analysis, one at a time and only after all checks: a user should learn of mistakes first.
void PrintQueue::analyze_next() {
  using Check = WaitingJob::Check;
  using Analysis = WaitingJob::Analysis;
  if (!questions_.wanted()) return;
  if (std::ranges::any_of(jobs_, &WaitingJob::is_looked_at)) return;
  const Position wanted = std::ranges::find_if(jobs_, [](const WaitingJob& job) {
    return job.check == Check::Passed && job.analysis == Analysis::Wanted;
  });
  if (wanted == jobs_.end()) return;
  wanted->analysis = Analysis::Running;
  const std::uint64_t number = wanted->check_number = ++checks_begun_;
  checks_.analyze(wanted->file, keep_for(wanted),
                  [this, file = wanted->file, number](const JobAnalysisOutcome& found) {
                    analyzed(file, number, found);
                  });
}

void PrintQueue::analyzed(const std::string& file, std::uint64_t number, const JobAnalysisOutcome& found) {
  const Position job = find(file);
  if (job != jobs_.end() && job->analysis == WaitingJob::Analysis::Running && job->check_number == number) {
    job->analysis = WaitingJob::Analysis::Wanted;
    if (job->check != WaitingJob::Check::Refused) {
      if (const auto* const refusal = final_refusal(found)) return reject(*job, refusal->reason);
      note_analysis(*job, found);
    }
  }
  observer_.queue_changed();
}

// Stores the result of an analysis for a job that stays in the queue.
void PrintQueue::note_analysis(WaitingJob& job, const JobAnalysisOutcome& found) {
  if (const auto* const refusal = std::get_if<JobRefusal>(&found)) {
    if (refusal->for_now) return postpone(job, refusal->reason);
    job.analysis = WaitingJob::Analysis::Blocked;
    const std::string trouble =
        fmt::format("{}; the queue continues when the profile is fixed", printable(refusal->profile));
    if (std::exchange(job.trouble, trouble) != trouble)
      log_.error("profile", fmt::format("{} waits: {}", printable(job.file), trouble), file_fields(job.file));
  } else if (const auto* const analyzed = std::get_if<AnalyzedJob>(&found)) {
    job.analysis = WaitingJob::Analysis::Done;
    job.trouble.clear();
    note_question(job, *analyzed);
  }
}

void PrintQueue::note_question(WaitingJob& job, const AnalyzedJob& analyzed) {
  job.asks = questions_.about(analyzed);
  job.analyzed = analyzed;
  if (job.asks.empty()) return;
  log_question(log_, job);
  observer_.question_changed();
}

void PrintQueue::accept(const std::string& file, const std::string& who) {
  const Position job = find(file);
  expects(job != jobs_.end() && !job->asks.empty() && job->analyzed, "the job waits for confirmation");
  questions_.accept(*job->analyzed, job->asks);
  log_.info("accepted",
            fmt::format("{}: accepted by {} with {}", printable(file), who, findings_text(job->asks)),
            file_fields(file));
  job->asks.clear();
  job->waited = true;
  observer_.question_changed();
  observer_.queue_changed();
}

std::size_t PrintQueue::first() const {
  return static_cast<std::size_t>(
      std::ranges::find_if(jobs_, [](const WaitingJob& job) { return job.asks.empty(); }) - jobs_.begin());
}

std::string PrintQueue::first_unanalyzed() const {
  expects(has_first(), "a job waits");
  const WaitingJob& job = jobs_[first()];
  if (!questions_.wanted() || job.analyzed || job.check == WaitingJob::Check::Refused) return "";
  if (!job.postponed.empty()) return job.postponed;
  if (!job.trouble.empty()) return job.trouble;
  return "its layers must be analyzed first, as ask_before requires";
}

bool PrintQueue::first_may_begin() const {
  expects(has_first(), "a job waits");
  return jobs_[first()].check != WaitingJob::Check::Running && rejections_ == 0;
}

WaitingJob& PrintQueue::next() {
  expects(has_first(), "a job waits");
  return jobs_[first()];
}

WaitingJob PrintQueue::take_first() {
  expects(has_first(), "a job waits");
  const std::size_t place = first();
  WaitingJob job = std::move(next());
  job.taken_from = place;
  jobs_.erase(jobs_.begin() + static_cast<std::ptrdiff_t>(place));
  return job;
}

void PrintQueue::begun(const WaitingJob& job) {
  order_.remove(job.file);
  questions_.begun(job.analyzed);
  if (has_first()) next().waited = true;
}

void PrintQueue::put_first(WaitingJob job) {
  const std::size_t place = std::min({job.taken_from, first(), jobs_.size()});
  jobs_.insert(jobs_.begin() + static_cast<std::ptrdiff_t>(place), std::move(job));
}

void PrintQueue::put_last(WaitingJob job) {
  order_.remove(job.file);
  checks_.forget(job.file);
  jobs_.push_back(std::move(job));
}

void PrintQueue::refuse_first(const std::string& reason) {
  expects(has_first(), "a job waits");
  reject(next(), reason);
}

void PrintQueue::remove(const std::string& file, const std::string& reason) {
  const Position job = find(file);
  expects(job != jobs_.end() && job->check != WaitingJob::Check::Refused, "the job waits");
  checks_.forget(file);
  reject(*job, reason, true);
}

void PrintQueue::move(const std::string& file, std::size_t to) {
  const Position job = find(file);
  expects(job != jobs_.end(), "the job waits");
  const auto from = static_cast<std::size_t>(job - jobs_.begin());
  to = std::min(to, jobs_.size() - 1);
  expects(std::max(from, to) < kMaxInOrder, "the places are among the first");
  if (from == to) return;
  std::vector<std::string_view> first;
  for (std::size_t i = 0; i <= std::max(from, to); ++i)
    first.push_back(jobs_[i].file);
  const std::size_t next = to < from ? to : to + 1;
  order_.move(file, next < jobs_.size() ? std::optional(jobs_[next].file) : std::nullopt, first);
  WaitingJob moved = std::move(*job);
  moved.waited = true;
  jobs_.erase(job);
  jobs_.insert(jobs_.begin() + static_cast<std::ptrdiff_t>(to), std::move(moved));
  log_.info("moved", fmt::format("{}: number {} in the queue now", printable(file), to + 1),
            file_fields(file));
  observer_.queue_changed();
}

void PrintQueue::reject(WaitingJob& job, const std::string& reason, bool removed) {
  job.check = WaitingJob::Check::Refused;
  ++rejections_;
  const JobEnd end{.key = new_job_key(),
                   .job = job_name_of(job.file),
                   .outcome = removed ? "cancelled" : "failed",
                   .reason = reason,
                   .ended = std::chrono::system_clock::now(),
                   .kind = JobEnd::Kind::Refused};
  checks_.reject(job.file, end,
                 [this, reject = Reject{job.file, end, removed}](const FileRejections::Result& result) {
                   rejected(reject, result);
                 });
}

void PrintQueue::rejected(const Reject& reject, const FileRejections::Result& result) {
  --rejections_;
  const Position job = std::ranges::find_if(jobs_, [&](const WaitingJob& each) {
    return each.file == reject.file && each.check == WaitingJob::Check::Refused;
  });
  if (result.rejection == Rejection::Unfinished) {
    if (reject.removed)
      log_.warning(
          "removed",
          fmt::format("{}: stays in the queue, because it is being rewritten", printable(reject.file)),
          file_fields(reject.file));
    return not_rejected(job);
  }
  if (job != jobs_.end()) {
    jobs_.erase(job);
    order_.remove(reject.file);
  }
  log_rejection(reject, result);
  EndedJob ended = ended_job(reject.end);
  ended.name = result.job;
  observer_.job_refused(std::move(ended));
  observer_.queue_changed();
}

// Keeps the job, which is being rewritten; it is checked again when it is complete.
void PrintQueue::not_rejected(const Position& job) {
  if (job != jobs_.end()) {
    if (job->withdrawn) return remove_withdrawn(job);
    job->check = job->seen_again ? WaitingJob::Check::Wanted : WaitingJob::Check::Passed;
    if (job->seen_again) job->analyze_again();
    job->seen_again = false;
  }
  observer_.queue_changed();
}

void PrintQueue::log_rejection(const Reject& job, const FileRejections::Result& result) const {
  const std::string file = printable(job.file);
  const std::string_view event = job.removed ? "removed" : "refused";
  log_.write(job.removed ? LogLevel::Info : LogLevel::Error, event,
             fmt::format("{}: {}", file, job.end.reason), file_fields(job.file));
  if (result.rejection == Rejection::LeftThere)
    log_.warning(event,
                 fmt::format("{}: stays in incoming, because it cannot be moved; it may be deleted", file),
                 file_fields(job.file));
  if (result.trouble.empty()) return;
  const std::string_view what = result.rejection == Rejection::Impossible ? "cannot be moved to failed"
                                                                          : "cannot write its reason file";
  log_.error(event, fmt::format("{}: {}: {}", file, what, printable(result.trouble)), file_fields(job.file));
}

LogFields file_fields(const std::string& file) {
  return job_fields(job_name_of(file));
}

void log_withdrawn(const Log& log, const std::string& file) {
  log.info("withdrawn", fmt::format("{}: removed from incoming by a user", printable(file)),
           file_fields(file));
}

}  // namespace contourd
