#include "daemon/history/history_worker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// The history's thread yields to the event loop and to all other work that is not in the background.
constexpr int kHistoryNiceness = 10;
// Delay before changes that could not be written are retried.
constexpr Duration kWriteRetryInterval = 30s;

HistoryWorker::AllUsage usage_of(HistoryDatabase& database) {
  return {database.usage(), database.usage_by_resin(), database.wear()};
}

}  // namespace

HistoryWorker::HistoryWorker(EventLoop& loop, const Log& log, const std::filesystem::path& file,
                             JobEndRecord& ends)
    : loop_(loop),
      log_(log),
      ends_(ends),
      database_(file),
      worker_(loop, "contourd-past", kHistoryNiceness) {}

// --- changes

void HistoryWorker::adopt_recorded_ends() {
  std::vector<JobEnd> ends;
  for (const JobEndRecord::Pending& each : ends_.pending())
    if (each.awaits(EndConsumer::History)) ends.push_back(each.end);
  change([this, ends = std::move(ends)](HistoryDatabase& database) {
    database.adopt(ends);
    for (const JobEnd& end : ends)
      ends_.taken(end.key, EndConsumer::History);
  });
}

std::int64_t HistoryWorker::begin(const std::string& name) {
  under_way_ = UnderWay{new_job_key(), name, std::chrono::system_clock::now(), std::nullopt};
  change([job = *under_way_](HistoryDatabase& database) { database.begin(job.key, job.name, job.began); });
  return under_way_->key;
}

void HistoryWorker::note(const std::function<JobFigures()>& figures) {
  const TimePoint now = std::chrono::steady_clock::now();
  if (!under_way_ || (under_way_->noted && now - *under_way_->noted < kNoteInterval)) return;
  note_now(figures());
}

void HistoryWorker::note_now(const JobFigures& figures) {
  if (!under_way_) return;
  under_way_->noted = std::chrono::steady_clock::now();
  worker_.run(
      [this, job = *under_way_, figures] {
        Health health =
            change_now_or_never([&](HistoryDatabase& database) { database.note(job.key, figures); });
        if (!health.trouble.empty()) {
          EndedJob interrupted = ended_job(interruption(job.key, job.name));
          interrupted.figures = figures;
          record(interrupted, JobEnd::Kind::Interrupted);
        }
        return health;
      },
      [this](const Health& health) { handle(health); });
}

void HistoryWorker::forget() {
  if (!under_way_) return;
  change([key = under_way_->key](HistoryDatabase& database) { database.forget(key); });
  under_way_.reset();
}

void HistoryWorker::end(EndedJob& job) {
  expects(under_way_.has_value(), "a job has begun");
  job.key = under_way_->key;
  job.began = under_way_->began;
  under_way_.reset();
  job.ended = std::chrono::system_clock::now();
  change([this, job](HistoryDatabase& database) {
    record(job);
    store_end(database, job);
  });
}

void HistoryWorker::refuse(EndedJob& job) {
  expects(job.key != 0, "the end has a key");
  job.began = job.ended = std::chrono::system_clock::now();
  change([this, job](HistoryDatabase& database) { store_end(database, job); });
}

void HistoryWorker::store_end(HistoryDatabase& database, const EndedJob& job) {
  database.end(job.key, job);
  ends_.taken(job.key, EndConsumer::History);
}

// Records the end before the history has it: the next process recognises it by its key.
void HistoryWorker::record(const EndedJob& job, JobEnd::Kind kind) {
  try {
    JobEnd end = job_end(job);
    end.kind = kind;
    ends_.add(end);
  } catch (const std::system_error&) {
    // A full disk has no room for the record. The files show the end until they are moved.
  }
}

void HistoryWorker::change(Change change) {
  worker_.run(
      [this, change = std::move(change)] {
        waiting_.push_back(change);
        if (waiting_.size() > kMostWaiting) {
          waiting_.pop_front();
          if (!std::exchange(loss_noted_, true))
            notes_.push_back(fmt::format(
                "more than {} changes of the history wait to be written; the oldest are lost", kMostWaiting));
        }
        return change_now_or_never({});
      },
      [this](const Health& health) { handle(health); });
}

void HistoryWorker::handle(const Health& health) {
  for (const std::string& note : health.notes)
    log_.error("history", printable(note));
  if (const bool well = health.trouble.empty(); std::exchange(logged_well_, well) != well) {
    if (well)
      log_.info("history", "the history can be used again");
    else
      log_.warning("history", printable(health.trouble) + "; printing continues");
  }
  if (!health.waits) return;
  retry_timer_ =
      loop_.at(std::chrono::steady_clock::now() + kWriteRetryInterval, "the history's timer", [this] {
        worker_.run([this] { return change_now_or_never({}); },
                    [this](const Health& later) { handle(later); });
      });
}

// --- on the worker's thread

void HistoryWorker::make_changes(const Change& change) {
  database_.use([&] {
    for (; !waiting_.empty(); waiting_.pop_front())
      waiting_.front()(database_);
    loss_noted_ = false;
    if (change) change(database_);
  });
}

HistoryWorker::Health HistoryWorker::change_now_or_never(const Change& change) {
  try {
    make_changes(change);
    trouble_.clear();
  } catch (const std::runtime_error& error) {
    trouble_ = error.what();
  }
  return health();
}

HistoryWorker::Health HistoryWorker::health() {
  std::vector<std::string> notes = database_.take_notes();
  std::ranges::move(std::exchange(notes_, {}), std::back_inserter(notes));
  return {trouble_, std::move(notes), !waiting_.empty()};
}

// --- queries

template <typename Answer, typename Question>
void HistoryWorker::ask(const ControlCaller& asker, Question question, Done<Answer> done) {
  struct Result {
    std::optional<Answer> answer;
    std::string trouble;
    Health health;
  };
  auto ask = [this, question = std::move(question), done = std::move(done)](bool gone) {
    const auto look_up = [this, question, gone] {
      Result result;
      if (gone) return result;
      try {
        make_changes([&](HistoryDatabase& database) { result.answer = question(database); });
      } catch (const std::runtime_error& error) {
        result.answer.reset();
        result.trouble = error.what();
      }
      result.health = health();
      return result;
    };
    worker_.run(look_up, [this, done, gone](Result result) {
      asking_ = false;
      ask_next();
      if (!gone) handle(result.health);
      done(std::move(result.answer), result.trouble);
    });
  };
  questions_.push_back({asker, std::move(ask)});
  ask_next();
}

void HistoryWorker::ask_next() {
  if (asking_ || questions_.empty()) return;
  asking_ = true;
  const auto next = next_question();
  const Waiting question = std::move(*next);
  questions_.erase(next);
  if (!question.gone) last_asker_ = question.asker.user;
  question.ask(question.gone);
}

// Returns the next query: first one of a closed connection, which takes no time; then users take turns.
std::deque<HistoryWorker::Waiting>::iterator HistoryWorker::next_question() {
  auto found = std::ranges::find(questions_, true, &Waiting::gone);
  if (found == questions_.end())
    found = std::ranges::find_if(
        questions_, [this](const Waiting& question) { return question.asker.user != last_asker_; });
  return found == questions_.end() ? questions_.begin() : found;
}

void HistoryWorker::disconnected(std::uint64_t connection) {
  for (Waiting& question : questions_)
    question.gone = question.gone || question.asker.connection == connection;
}

void HistoryWorker::list(const HistoryQuery& query, const ControlCaller& asker, Done<HistoryPage> done) {
  ask<HistoryPage>(
      asker, [query](HistoryDatabase& database) { return database.list(query); }, std::move(done));
}

void HistoryWorker::usage(const ControlCaller& asker, Done<AllUsage> done) {
  ask<AllUsage>(asker, usage_of, std::move(done));
}

void HistoryWorker::wear(Done<std::vector<WearPartUse>> done) {
  ask<std::vector<WearPartUse>>(
      {}, [](HistoryDatabase& database) { return database.wear(); }, std::move(done));
}

void HistoryWorker::replace(WearPart part, const ControlCaller& asker, Done<AllUsage> done) {
  ask<AllUsage>(
      asker,
      [part, when = std::chrono::system_clock::now()](HistoryDatabase& database) {
        database.replace(part, when);
        return usage_of(database);
      },
      std::move(done));
}

}  // namespace contourd
