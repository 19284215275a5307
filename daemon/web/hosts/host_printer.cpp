#include "daemon/web/hosts/host_printer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/web/hosts/host_replies.hpp"
#include "daemon/web/printer/fetched_file.hpp"
#include "daemon/web/printer_answer.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

// Time for which a job that leaves the queue may be neither in it nor under way, if the disk is slow.
constexpr std::chrono::seconds kLongestLeaving{10};

bool is_host_method(std::string_view method) {
  return method == kHostStop || std::ranges::find(kHostMethods, method) != kHostMethods.end();
}

// Returns the job that would begin instead of this one; null if there is none. A job that asks for nothing
// begins when its turn comes, and one that is ready may be about to.
const HostJob* rival_of(const HostJob& job, const std::vector<HostJob>& jobs) {
  bool is_before = true;
  for (const HostJob& each : jobs) {
    if (each.file == job.file) {
      is_before = false;
    } else if (!each.is_printing && each.asks.empty() &&
               (is_before || (each.state == "ready" && job.state != "ready"))) {
      return &each;
    }
  }
  return nullptr;
}

// Returns why a job cannot begin at once; empty if it can.
std::string why_no_start(const HostJob& job, const std::vector<HostJob>& jobs, const Json& status) {
  if (job.is_printing) return fmt::format("{} is being printed already", printable(job.name));
  if (const std::optional<HostJob> print = host_print(status))
    return fmt::format("{} is being printed: wait for its end, or cancel it", printable(print->name));
  // A held queue comes first: the part of an interrupted print may be on the plate to be gone on with.
  for (const char* reason : {"held", "not_ready_reason"})
    if (std::string why = json_text(status, reason); !why.empty()) return why;
  if (const auto manual = status.find("manual");
      manual != status.end() && manual->is_object() && json_text(*manual, "state") != "idle")
    return "the printer is controlled by hand: start again when manual control has ended";
  if (json_text(status, "plate") != "clear")
    return "a part is on the plate: clear the plate, say so on the printer's page (The plate is clear), and "
           "start again";
  if (const HostJob* const rival = rival_of(job, jobs))
    return fmt::format("{0} is printed first: wait for its end, or remove {0} from the queue",
                       printable(rival->file));
  if (job.state == "ready") return "";
  if (job.state != "unaccepted")
    return job.waiting_for.empty()
               ? fmt::format("{} is being checked: start it again in a moment", printable(job.file))
               : job.waiting_for;
  const bool has_findings =
      std::ranges::any_of(job.asks, [](const std::string& ask) { return ask != "to_be_confirmed"; });
  if (!has_findings) return "";
  return fmt::format("{} has findings, so it must be accepted on the printer's page: {}", printable(job.file),
                     job.warnings.empty() ? fmt::format("{}", fmt::join(job.asks, ", "))
                                          : fmt::format("{}", fmt::join(job.warnings, "; ")));
}

}  // namespace

struct HostPrinter::Questions {
  RequestPtr request;
  std::vector<Request> questions;
  std::function<void(const std::vector<Json>& results)> answered;
  std::vector<Json> results{};
};

HostPrinter::HostPrinter(EventLoop& loop, const Log& log, const WebConfig& config)
    : log_(log),
      socket_(config.control_socket),
      printer_(loop, config.control_socket),
      slow_(loop, config.control_socket, ControlLink::kLongPatience),
      mask_(printer_),
      disk_(loop, "web-disk"),
      uploads_{
          .disk = disk_,
          .printer = printer_,
          .limits = {.most_bytes = config.largest_upload_bytes, .free_bytes = config.min_free_disk_bytes}} {}

void HostPrinter::ask(const RequestPtr& request, std::vector<Request> questions,
                      std::function<void(const std::vector<Json>& results)> answered) {
  ask_next(std::make_shared<Questions>(Questions{request, std::move(questions), std::move(answered)}));
}

void HostPrinter::ask_next(const std::shared_ptr<Questions>& questions) {
  const std::size_t next = questions->results.size();
  if (next == questions->questions.size()) return questions->answered(questions->results);
  Request question = questions->questions[next];
  expects(is_host_method(question.method), "the method is one of other print hosts");
  // The resins are read from a disk.
  ControlLink& link = question.method == "resins" ? slow_ : printer_;
  link.call(std::move(question), [this, questions](const Json& answer) {
    if (!answer.contains("result")) return questions->request->answer(reply_of(answer));
    questions->results.push_back(answer["result"]);
    note_begin(answer["result"]);
    ask_next(questions);
  });
}

bool HostPrinter::is_leaving() const {
  return leaving_ && std::chrono::steady_clock::now() < leaving_->until;
}

// Notes by a status that the job which was started last has begun, or has ended.
void HostPrinter::note_begin(const Json& status) {
  const auto last = status.find("last");
  const bool has_ended =
      leaving_ && last != status.end() && last->is_object() && json_text(*last, "job") == leaving_->name;
  if (has_ended || host_print(status)) leaving_.reset();
}

void HostPrinter::call(const RequestPtr& request, Request question, Done done) {
  log_command(*request, question.method);
  ask(request, {std::move(question)}, [done = std::move(done)](const auto& /*results*/) { done(); });
}

void HostPrinter::log_command(const HttpRequest& request, std::string_view method) const {
  log_.info("command", fmt::format("{} from {}", method, request.peer()));
}

void HostPrinter::read_status(const RequestPtr& request, std::function<void(const HostStatus& status)> read) {
  ask(request, {{"status"}},
      [this, read = std::move(read)](const auto& results) { read(reader_.read(results[0])); });
}

void HostPrinter::list_jobs(const RequestPtr& request,
                            std::function<void(const std::vector<HostJob>& jobs)> listed) {
  ask(request, {{"status"}, {"queue"}},
      [listed = std::move(listed)](const auto& results) { listed(host_jobs(results[0], results[1])); });
}

void HostPrinter::find(const RequestPtr& request, const HostJobKey& key,
                       std::function<void(const HostJob& job, const Found& among)> found) {
  ask(request, {{"status"}, {"queue"}}, [request, key, found = std::move(found)](const auto& results) {
    const Found among{host_jobs(results[0], results[1]), results[0]};
    std::vector<HostJob> jobs = among.jobs;
    std::erase_if(
        jobs, [&key](const HostJob& job) { return key.id ? job.id() != *key.id : !job.is_file(key.file); });
    if (jobs.size() == 1) return found(jobs.front(), among);
    if (jobs.empty())
      return refuse_host_request(*request, 404, "the printer has no such job: read the list again");
    refuse_host_request(*request, 409,
                        fmt::format("{} and {} have the same number: rename one of them",
                                    printable(jobs[0].file), printable(jobs[1].file)));
  });
}

void HostPrinter::start(const RequestPtr& request, const HostJobKey& key, Done done) {
  if (!start_.expired())
    return refuse_host_request(*request, kConflict, "a job is being started: start this one in a moment");
  const auto turn = std::make_shared<const bool>();
  start_ = turn;
  find(request, key, [this, request, turn, done = std::move(done)](const HostJob& job, const Found& among) {
    std::string why = why_no_start(job, among.jobs, among.status);
    if (why.empty() && is_leaving() &&
        std::ranges::find(among.jobs, leaving_->file, &HostJob::file) == among.jobs.end())
      why = fmt::format("{} is printed first: wait for its end, or cancel it", printable(leaving_->name));
    if (!why.empty()) return refuse_host_request(*request, kConflict, why);
    if (job.state == "ready") return done();
    call(request, {"accept", {{"job", job.file}}}, [this, turn, done, name = job.name, file = job.file] {
      leaving_ = {name, file, std::chrono::steady_clock::now() + kLongestLeaving};
      done();
    });
  });
}

void HostPrinter::remove(const RequestPtr& request, const HostJobKey& key,
                         std::function<void(const HostJob& job)> removed) {
  find(request, key, [this, request, removed = std::move(removed)](const HostJob& job, const Found&) {
    if (job.is_printing)
      return refuse_host_request(*request, kConflict,
                                 fmt::format("{} is being printed: cancel it first", printable(job.name)));
    call(request, {"queue_remove", {{"job", job.file}}}, [removed, job] { removed(job); });
  });
}

void HostPrinter::control(const RequestPtr& request, std::string_view method, Done done) {
  log_command(*request, method);
  ask(request, {{std::string(method)}}, [this, method, done = std::move(done)](const auto& results) {
    (void)reader_.read(results[0]);  // the reply is a status
    if (method == "cancel") reader_.is_cancelled();
    done();
  });
}

void HostPrinter::stop_all(const RequestPtr& request, Done done) {
  read_status(request, [this, request, done = std::move(done)](const HostStatus& status) {
    if (is_leaving())
      return refuse_host_request(
          *request, kConflict,
          fmt::format("{} is about to begin, and cannot be cancelled yet: stop it again",
                      printable(leaving_->name)));
    control(request, status.job ? "cancel" : kHostStop, done);
  });
}

void HostPrinter::show(const RequestPtr& request, const HostJobKey& key) {
  find(request, key, [this, request](const HostJob& job, const Found&) {
    if (job.is_printing) return show_mask(request);
    show_preview(request, job);
  });
}

void HostPrinter::show_preview(const RequestPtr& request, const HostJob& job) {
  fetch_file(slow_, {.method = "preview", .parameters = {{"job", job.file}}},
             [request](std::string png, const Json& error) {
               if (png.empty()) return request->answer(reply_of({{"error", error}}));
               request->answer({.type = "image/png", .body = std::move(png)});
             });
}

void HostPrinter::show_mask(const RequestPtr& request) {
  mask_.fetch([request](const std::string& png, const Json& error) {
    if (!png.empty()) return request->answer({.type = "image/png", .body = png});
    request->answer(reply_of({{"error", error}}));
  });
}

void HostPrinter::note_upload(const HttpRequest& request, const std::string& job) const {
  log_.info("uploaded", fmt::format("{} from {}", printable(job), request.peer()), job_fields(job));
}

}  // namespace contourd::web
