#include "daemon/app/printer_service.hpp"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <utility>

#include "daemon/control/printer_metrics.hpp"
#include "daemon/spool/state_folder.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/system_users.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// Time that a stop waits for a print to be filed; the service manager waits longer (contourd.service).
constexpr Duration kLongestFiling = 15s;
// Encoding pictures for clients is less urgent than all other work.
constexpr int kPictureNiceness = 10;

// Logs the command with the user and the process of its caller.
void log_command(const Log& log, const std::string& method, const ControlServer::Peer& peer) {
  log.info("command",
           fmt::format("{} requested by user {} (process {})", method, user_name(peer.user), peer.process),
           {{"PEER_UID", std::to_string(peer.user)}, {"PEER_PID", std::to_string(peer.process)}});
}

}  // namespace

PrinterService::PrinterService(const PrinterConfig& config, EventLoop& loop, Clock& clock, Machine& machine,
                               const Log& log, Supervisor& supervisor)
    : context_{config, loop, clock, machine, log, supervisor},
      incoming_router_(log, queue_),
      spool_(config.spool_folder, loop, incoming_router_),
      reader_(config, spool_, loop),
      hold_(context_, spool_, calls_of_hold()),
      queue_(log, calls_of_queue()),
      job_(context_, spool_, reader_, hold_, *this),
      scheduler_(context_, spool_, queue_, hold_, calls_of_scheduler()),
      history_worker_(loop, log, state_folder_path(config.spool_folder) / "history.sqlite"),
      notices_(loop, log, config.job_ended_socket, config.name),
      manual_(machine, clock, [this] { manual_changed(); }),
      reminders_(config.reminders),
      status_(context_, {spool_, queue_, scheduler_, hold_, job_, history_, manual_, reminders_}),
      control_(context_, hold_, job_, scheduler_, status_),
      queue_control_(queue_, job_, status_),
      picture_worker_(loop, "contourd-picture", kPictureNiceness),
      manual_control_(context_, {hold_, job_, scheduler_, status_}, manual_, picture_worker_),
      history_control_(history_worker_, history_, reminders_, [this](WearPart part) { part_replaced(part); }),
      screen_control_(loop, picture_worker_, job_, manual_) {}

PrinterService::~PrinterService() {
  context_.loop.on_turn_over(nullptr);
}

QueueHold::Calls PrinterService::calls_of_hold() {
  return {.light_may_be_on = [this] { return job_.print().light_may_be_on() || manual_.light_may_be_on(); },
          .retry = [this] { scheduler_.run(); },
          .filed = [this](const EndedJob& job) { notices_.add(job); }};
}

PrintQueue::Calls PrinterService::calls_of_queue() {
  PrintQueue::Calls calls{
      .check = [this](const std::string& file, JobReader::Keep keep,
                      auto done) { reader_.check(file, keep, std::move(done)); },
      .forget = [this](const std::string& file) { reader_.forget(file); },
      .reject = [this](const std::string& file, const std::string& reason,
                       Spool::Rejected done) { spool_.reject(file, reason, std::move(done)); },
      .changed = [this] { scheduler_.run(); },
      .refused =
          [this](const std::string& file, const std::string& reason) {
            note_refusal({job_name_of(file), "failed", reason});
          },
      .removed =
          [this](const std::string& file, const std::string& reason) {
            note_refusal({job_name_of(file), "cancelled", reason});
          },
      .keep_order =
          [this](const QueueOrder::Names& files, auto done) {
            spool_.keep([files](const StateRecords& records) { records.keep_queue_order(files); },
                        std::move(done));
          }};
  calls.questions.changed = [this] { notify("question", ControlServer::Delivery::Lossy); };
  calls.questions.asked = [this](const PreprintAnalysis& analysis) {
    return asked_findings(analysis, context_.config);
  };
  calls.questions.keep_accepted = [this](const RecordKeeper::Lines& lines, auto done) {
    spool_.keep([lines](const StateRecords& records) { records.keep_accepted(lines); }, std::move(done));
  };
  if (context_.config.ask_before.empty()) return calls;
  calls.questions.analyze = [this](const std::string& file, JobReader::Keep keep, auto done) {
    reader_.analyze(file, keep, std::move(done));
  };
  return calls;
}

JobScheduler::Calls PrinterService::calls_of_scheduler() {
  return {.has_job = [this] { return job_.job() != nullptr; },
          .prints = [this] { return job_.print().state() != PrintState::Idle || manual_.light_may_be_on(); },
          .controlled_by_hand = [this] { return controlled_by_hand(); },
          .begin =
              [this](ClaimedJob job) {
                manual_.give_way();
                job.key = history_worker_.begin(job.files.name);
                job_.begin(std::move(job));
              },
          .copy_over = [this] { may_stop(); }};
}

void PrinterService::start() {
  context_.loop.on_turn_over([this](const EventLoop::Turn& turn) {
    if (job_.print().light_may_be_on()) job_.add_lit_turn(turn);
  });
  context_.machine.on_event([this](const MachineEvent& event) { handle_event(event); });
  const Log& log = context_.log;
  if (const std::string not_ready = context_.machine.why_not_ready(); !not_ready.empty())
    log.error("machine", fmt::format("the printer cannot print: {}", printable(not_ready)));
  hold_.load();
  if (const std::string trouble = spool_.trouble(); !trouble.empty()) log.error("spool", printable(trouble));
  adopt_left_jobs();
  if (hold_.reason()) log.warning("held", hold_.sentence());
  ControlMethods methods = control_.methods();
  methods.merge(queue_control_.methods());
  methods.merge(manual_control_.methods());
  methods.merge(history_control_.methods());
  methods.merge(screen_control_.methods());
  server_ =
      std::make_unique<ControlServer>(context_.loop, context_.config.control_socket, std::move(methods));
  server_->set_service_group(find_group("contourd-service"));
  server_->on_disconnected([this](std::uint64_t connection) {
    manual_control_.disconnected(connection);
    history_control_.disconnected(connection);
  });
  server_->on_call(
      [&log](const std::string& method, const ControlServer::Peer& peer) { log_command(log, method, peer); });
  queue_.load_order(spool_.order());
  queue_.questions().load_accepted(spool_.records().accepted());
  spool_.open();
  if (context_.config.metrics_file)
    metrics_file_.emplace(context_.loop, log, *context_.config.metrics_file, [this] { return metrics(); });
  context_.supervisor.status(readiness());
  scheduler_.run_soon();
}

void PrinterService::adopt_left_jobs() {
  const auto ended = [](const std::string& name, const PrintEnd& end) {
    const auto now = std::chrono::system_clock::now();
    return EndedJob{.name = name,
                    .outcome = std::string(name_of(end.outcome)),
                    .reason = end.reason,
                    .began = now,
                    .ended = now,
                    .key = end.key};
  };
  std::optional<EndedJob> last_end;
  if (const std::optional<RecordedEnd> last = last_recorded_end(spool_))
    last_end = ended(last->job, last->end);
  std::vector<EndedJob> left;
  for (const auto& [name, end] :
       hold_.adopt_left_jobs([this](const JobFiles& files) { return reader_.take_ended(files); }))
    left.push_back(ended(name, end));
  history_worker_.adopt(std::move(left), std::move(last_end));
  remind();
}

void PrinterService::part_replaced(WearPart part) {
  context_.log.info("reminder", fmt::format("the {} is new: its use counts from now on", name_of(part)));
  notify("reminders", ControlServer::Delivery::Lossy);
}

void PrinterService::remind() {
  if (!reminders_.wanted()) return;
  history_worker_.wear([this](const std::optional<std::vector<WearPartUse>>& uses, const std::string&) {
    if (!uses) return;  // the worker has reported why
    reminders_.update(*uses);
    if (reminders_.due().empty()) return;
    for (const std::string& sentence : reminders_.due())
      context_.log.warning("reminder", sentence);
    notify("reminders", ControlServer::Delivery::Lossy);
  });
}

std::string PrinterService::metrics() const {
  PrinterMetrics metrics = status_.metrics();
  metrics.lit = lit_;
  return as_open_metrics(metrics);
}

std::string PrinterService::readiness() const {
  const std::string not_ready = context_.machine.why_not_ready();
  if (!not_ready.empty()) return "Cannot print: " + printable(not_ready);
  return hold_.reason() ? "Waiting for the user: " + hold_.sentence() : "Ready";
}

// --- shutdown

void PrinterService::shut_down(const std::string& reason) {
  ending_ = Ending::ShutDown;
  scheduler_.stop();
  end_manual_control();
  reader_.stop();
  job_.stop(reason);
  may_stop();
}

void PrinterService::hand_over_when_idle() {
  const bool prints = job_.print().state() != PrintState::Idle || job_.finishing();
  context_.log.info("restart", prints
                                   ? fmt::format("contourd restarts when {} is over", printable(job_.name()))
                                   : "contourd restarts");
  ending_ = Ending::HandOver;
  scheduler_.stop();
  end_manual_control();
  may_stop();
}

// Does nothing until the current print has ended: the loop must run to turn its light off.
void PrinterService::may_stop() {
  if (ending_ == Ending::No || job_.print().state() != PrintState::Idle || controlled_by_hand()) return;
  if (ending_ == Ending::HandOver && job_.finishing()) return;  // called again after filing
  job_.stop_analysis();
  if (job_.is_being_filed()) {
    if (!stop_timer_)
      stop_timer_ = context_.loop.at(std::chrono::steady_clock::now() + kLongestFiling, "the stop's timer",
                                     [this] { stop_waiting_for_filing(); });
    return;
  }
  if (scheduler_.copying()) return spool_.stop_copying();  // called again after it
  // The job is still being read and nothing was printed: it waits for the next start.
  if (job_.job() != nullptr) {
    history_worker_.forget();
    job_.give_back();
  }
  if (hold_.due()) hold_.keep();
  context_.loop.stop();
}

// The archivist still completes the filing that has begun, or the next start does.
void PrinterService::stop_waiting_for_filing() {
  const std::string& name = job_.name();
  context_.log.error(
      "stopped",
      fmt::format("{}: not filed after {:.0f} s: the disk does not answer, or this computer is too slow",
                  printable(name), milliseconds(kLongestFiling) / 1000),
      job_fields(name));
  context_.loop.stop();
}

// --- the machine's events

void PrinterService::handle_event(const MachineEvent& event) {
  PrintProcess& print = job_.print();
  const bool printing = print.state() != PrintState::Idle && print.state() != PrintState::Ending;
  switch (event.kind) {
    case MachineEvent::Kind::Fault:
      print.fail(event.what);
      break;
    case MachineEvent::Kind::Interlock:
      print.interrupt(event.what);
      break;
    case MachineEvent::Kind::Recovery:
    case MachineEvent::Kind::Notice:
      break;
  }
  if (event.kind == MachineEvent::Kind::Fault || event.kind == MachineEvent::Kind::Interlock)
    manual_.fail(event.what);
  const bool bad = event.kind != MachineEvent::Kind::Recovery;
  const bool of_print =
      event.kind == MachineEvent::Kind::Fault || event.kind == MachineEvent::Kind::Interlock;
  // An event that ends or interrupts a print is logged with the print.
  if (!of_print || !printing)
    context_.log.write(bad ? LogLevel::Warning : LogLevel::Info, "machine", printable(event.what));
  for (const std::string& warning : event.warnings)
    context_.log.warning("machine", printable(warning));
  if (event.needs_user) hold_.hold(event.what);
  if (print.state() == PrintState::Idle) context_.supervisor.status(readiness());
  notify("machine", ControlServer::Delivery::Lossy);
  scheduler_.run_soon();
}

// --- manual control

void PrinterService::manual_changed() {
  if (manual_.state() == ManualState::Idle &&
      std::exchange(manual_operations_logged_, manual_.operations()) != manual_.operations()) {
    const std::string& problem = manual_.problem();
    context_.log.write(problem.empty() ? LogLevel::Info : LogLevel::Warning, "manual",
                       "by hand: " + (problem.empty() ? "done" : printable(problem)));
  }
  if (printing_) printing_(controlled_by_hand());
  notify("manual", ControlServer::Delivery::Certain);
  if (controlled_by_hand()) return;
  scheduler_.run_soon();
  may_stop();
}

void PrinterService::end_manual_control() {
  manual_.stop();
  manual_.hide();
}

// --- the job's events

void PrinterService::print_state_changed(PrintState state) {
  if (printing_) printing_(state != PrintState::Idle);
}

void PrinterService::job_changed(const std::string& what) {
  if (what == "layer") {
    lit_ += job_.job()->record->layers().back().exposure_most;
    history_worker_.note([this] { return job_.figures(); });
  }
  notify(what, ControlServer::Delivery::Lossy);
}

void PrinterService::light_gone() {
  if (hold_.due()) scheduler_.run_soon();
}

std::shared_future<void> PrinterService::print_over(EndedJob& job) {
  return history_worker_.end(job);
}

void PrinterService::job_ended(EndedJob job) {
  const bool was_refused = job.ended == std::chrono::system_clock::time_point{};
  if (was_refused) history_worker_.end(job);
  queue_.questions().ended();
  note_end(std::move(job));
  if (!was_refused) remind();
  scheduler_.run_soon();
}

void PrinterService::note_refusal(EndedJob job) {
  history_worker_.refuse(job);
  note_end(std::move(job));
}

void PrinterService::note_end(EndedJob job) {
  const std::string last = fmt::format("last job {}: {}", printable(job.name), job.outcome);
  notices_.add(job);
  history_.add(std::move(job));
  context_.supervisor.status(fmt::format("{}; {}", readiness(), last));
  notify("ended", ControlServer::Delivery::Certain);
}

// Logs a failure of the socket: it must not disturb a print.
void PrinterService::notify(const std::string& what, ControlServer::Delivery delivery) {
  try {
    if (server_ && server_->is_watched()) server_->notify(what, status_.status(), delivery);
  } catch (const std::exception& error) {
    context_.log.warning("control", fmt::format("the control socket failed: {}", error.what()));
  }
}

}  // namespace contourd
