#include "daemon/app/printer_service.hpp"

#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <utility>

#include "daemon/control/printer_metrics.hpp"
#include "daemon/spool/state_records.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/system_users.hpp"

namespace contourd {
namespace {

// Encoding pictures for clients is less urgent than all other work.
constexpr int kPictureNiceness = 10;
constexpr Duration kChangeInterval = std::chrono::milliseconds(20);

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
      hold_(context_, spool_, *this),
      vat_(spool_),
      queue_(config, reader_, *this, log),
      history_worker_(loop, log, state_folder_path(config.spool_folder) / "history.sqlite", spool_.ends()),
      job_(context_, spool_, reader_, hold_, history_worker_, *this),
      claims_(spool_, config),
      scheduler_(context_, spool_, claims_, queue_, hold_, *this),
      notices_(loop, log, config.job_ended_socket, config.name,
               [this](std::int64_t key) { notice_sent(key); }),
      camera_(loop, log, config),
      manual_(machine, clock, [this] { manual_changed(); }),
      stop_(context_, {spool_, reader_, job_, scheduler_, manual_}),
      reminders_(config.reminders),
      status_(context_, {spool_, queue_, scheduler_, hold_, job_, history_, manual_, reminders_, camera_}),
      control_(context_, hold_, job_, scheduler_, status_),
      queue_control_(queue_, job_, status_),
      picture_worker_(loop, "contourd-picture", kPictureNiceness),
      manual_control_(context_, {hold_, job_, scheduler_, status_}, manual_, picture_worker_),
      history_control_(history_worker_, history_, reminders_, [this](WearPart part) { part_replaced(part); }),
      preflight_control_(context_,
                         {spool_, vat_, queue_, queue_control_, hold_, history_worker_, reminders_}),
      screen_control_(loop, picture_worker_, job_, manual_),
      interrupted_control_(context_, {spool_, hold_, *this, manual_, status_}),
      waiting_job_control_(config, {spool_, reader_, queue_, queue_control_}),
      resin_control_(config, spool_),
      report_control_(spool_),
      picture_control_(spool_, config.spool_folder),
      log_control_(log) {}

// --- the use of the printer

void PrinterService::begin(ClaimedJob job) {
  manual_.give_way();
  job_.begin(std::move(job));
}

// --- the start

void PrinterService::start() {
  context_.machine.on_event([this](const MachineEvent& event) { handle_event(event); });
  const Log& log = context_.log;
  if (const std::string not_ready = context_.machine.why_not_ready(); !not_ready.empty())
    log.error("machine", fmt::format("the printer cannot print: {}", printable(not_ready)));
  hold_.load();
  vat_.load();
  if (const std::string trouble = spool_.trouble(); !trouble.empty()) log.error("spool", printable(trouble));
  adopt_left_jobs();
  camera_.job_filed("");
  if (hold_.reason()) log.warning("held", hold_.sentence());
  server_ = std::make_unique<ControlServer>(context_.loop, context_.config.control_socket, control_methods());
  server_->set_service_group(find_group("contourd-service"));
  server_->on_disconnected([this](std::uint64_t connection) {
    manual_control_.disconnected(connection);
    history_control_.disconnected(connection);
  });
  server_->on_call(
      [&log](const std::string& method, const ControlServer::Peer& peer) { log_command(log, method, peer); });
  server_->on_changed([this] { note_change(); });
  queue_.load_order(spool_.order());
  queue_.questions().load_accepted(spool_.records().accepted());
  spool_.open();
  if (context_.config.metrics_file)
    metrics_file_.emplace(context_.loop, log, *context_.config.metrics_file,
                          [this] { return as_open_metrics(status_.metrics()); });
  context_.supervisor.status(readiness());
  scheduler_.run_soon();
  interrupted_control_.go_on_by_policy();
}

ControlMethods PrinterService::control_methods() {
  ControlMethods methods = control_.methods();
  methods.merge(queue_control_.methods());
  methods.merge(manual_control_.methods());
  methods.merge(history_control_.methods());
  methods.merge(preflight_control_.methods());
  methods.merge(screen_control_.methods());
  methods.merge(interrupted_control_.methods());
  methods.merge(waiting_job_control_.methods());
  methods.merge(resin_control_.methods());
  methods.merge(report_control_.methods());
  methods.merge(picture_control_.methods());
  methods.merge(log_control_.methods());
  return methods;
}

void PrinterService::adopt_left_jobs() {
  hold_.adopt_left_jobs([this](const JobFiles& files) { return reader_.take_ended(files); });
  history_worker_.adopt_recorded_ends();
  for (const JobEndRecord::Pending& each : spool_.ends().pending()) {
    const bool waits = hold_.interrupted() && hold_.interrupted()->files.name == each.end.job;
    if ((each.awaits(EndConsumer::Files) && !waits) || !each.awaits(EndConsumer::Notice)) continue;
    EndedJob ended = ended_job(each.end);
    ended.reports = spool_.reports_of(folder_for(each.end), ended.name);
    notices_.add(ended);
  }
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

std::string PrinterService::readiness() const {
  const std::string not_ready = context_.machine.why_not_ready();
  if (!not_ready.empty()) return "Cannot print: " + printable(not_ready);
  return hold_.reason() ? "Waiting for the user: " + hold_.sentence() : "Ready";
}

// --- the machine's events

void PrinterService::handle_event(const MachineEvent& event) {
  PrintMode& print = job_.print();
  const bool printing = print.under_way() && !print.state().ending;
  const bool fault = event.kind == MachineEvent::Kind::Fault;
  const bool interlock = event.kind == MachineEvent::Kind::Interlock;
  if (fault) print.fail(event.what);
  if (interlock) print.interrupt(event.what);
  if (fault || interlock) manual_.fail(event.what);
  // An event that ends or interrupts a print is logged with the print.
  const bool bad = event.kind != MachineEvent::Kind::Recovery;
  if (!printing || !(fault || interlock))
    context_.log.write(bad ? LogLevel::Warning : LogLevel::Info, "machine", printable(event.what));
  for (const std::string& warning : event.warnings)
    context_.log.warning("machine", printable(warning));
  if (event.needs_user) hold_.hold(event.what);
  if (!print.under_way()) context_.supervisor.status(readiness());
  notify("machine", ControlServer::Delivery::Lossy);
  scheduler_.run_soon();
  interrupted_control_.go_on_by_policy();
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

// --- the job's events

void PrinterService::print_state_changed(const PrintState& state) {
  if (printing_) printing_(state != kIdle);
  const bool lifted =
      std::exchange(lifting_, state.cause == TimeCause::Lifting) && state.activity != PrintActivity::Moving;
  if (lifted && !state.ending) look();
}

void PrinterService::look() {
  const CurrentJob::State* const job = job_.job();
  if (job == nullptr || !job->prepared || !job_.print().under_way()) return;
  const PrintMode& print = job_.print();
  camera_.look({job_.name(), print.layer(), static_cast<std::int32_t>(job->prepared->summary.layers.count),
                print.layer_top()});
}

void PrinterService::job_changed(const std::string& what) {
  if (what == "analysis") compare_with_vat();
  if (what == "layer" && job_.job()->record->layers().back().rises) look();
  notify(what, ControlServer::Delivery::Lossy);
}

void PrinterService::compare_with_vat() {
  const CurrentJob::State& job = *job_.job();
  if (!vat_.ml() || !job.analysis.is_object() || !job.record) return;
  const double used_ml = exposed_volume_mm3(job.record->layers()) / 1000;
  const double needed_ml = job.analysis.value("resin_ml", 0.0) - used_ml;
  if (job.prepared->summary.dry || needed_ml <= *vat_.ml()) return;
  context_.log.warning("resin",
                       fmt::format("{}: needs {:.1f} ml of resin from now on, the vat holds about {:.1f} ml",
                                   printable(job_.name()), needed_ml, *vat_.ml()),
                       job_fields(job_.name()));
}

// Interrupts the print in a turn of its own, because the print mode reports the resin from within.
void PrinterService::resin_used(double ml) {
  const std::string low = vat_.use(ml);
  if (low.empty()) return;
  low_resin_timer_ = context_.loop.at(std::chrono::steady_clock::now(), "the resin in the vat",
                                      [this, low] { job_.print().interrupt(low); });
}

void PrinterService::job_ended(EndedJob job) {
  vat_.save();
  queue_.questions().ended();
  camera_.job_filed(job.name);
  const bool was_printed = job.figures.layers > 0;
  if (was_printed) queue_.check_postponed();
  note_end(std::move(job));
  if (was_printed) remind();
  scheduler_.run_soon();
}

void PrinterService::job_refused(EndedJob job) {
  history_worker_.refuse(job);
  note_end(std::move(job));
}

void PrinterService::notice_sent(std::int64_t key) {
  spool_.keep([&ends = spool_.ends(), key](const StateRecords&) { ends.taken(key, EndConsumer::Notice); },
              [](const std::string&) {});
}

void PrinterService::note_end(EndedJob job) {
  const std::string last = fmt::format("last job {}: {}", printable(job.name), job.outcome);
  notices_.add(job);
  history_.add(std::move(job));
  context_.supervisor.status(fmt::format("{}; {}", readiness(), last));
  notify("ended", ControlServer::Delivery::Certain);
}

void PrinterService::note_change() {
  if (change_timer_) return;
  change_timer_ =
      context_.loop.at(std::chrono::steady_clock::now() + kChangeInterval, "the watching clients", [this] {
        change_timer_.reset();
        notify("change", ControlServer::Delivery::Lossy);
      });
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
