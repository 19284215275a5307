#include "daemon/printer_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "daemon/durable_file.hpp"
#include "daemon/print_findings.hpp"
#include "daemon/readable.hpp"
#include "daemon/state_folder.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// How long until what the disk did not take is tried again.
constexpr Duration kRetryInterval = 30s;
// The same for a resin's profile, by which its owner may be sitting.
constexpr Duration kProfileInterval = 5s;
// How long a stop waits for a print to be filed; the service manager waits for longer (contourd.service).
constexpr Duration kLongestFiling = 15s;
// A model that is read beside a print gives way to the event loop.
constexpr int kNiceness = 5;
// What is told of why a job is refused goes into the log, a file and each answer to a client.
constexpr std::size_t kLongestReason = 8000;
constexpr std::size_t kMostWarnings = 20;
// In the state folder: see reading_record.hpp.
constexpr const char* kReadingRecord = "reading";
// How many ended jobs are remembered for whoever asks.
constexpr std::size_t kLongestHistory = 100;

LogFields file_fields(const std::string& file) {
  return job_fields(job_name_of(file));
}

// "434000 facets, 20.00 x 20.00 x 40.00 mm", or what is on the plate.
std::string content_of(const JobSummary& summary) {
  if (!summary.plate) {
    const ModelSummary& model = summary.models.front();
    return fmt::format("{} facets, {:.2f} x {:.2f} x {:.2f} mm", model.mesh.facets, model.size_x_mm,
                       model.size_y_mm, model.size_z_mm);
  }
  std::size_t parts = 0;
  std::uint64_t facets = 0;
  for (const ModelSummary& model : summary.models) {
    parts += model.centers.size();
    facets += model.mesh.facets;
  }
  return fmt::format("{} models, {} parts, {} facets, {:.2f} mm high", summary.models.size(), parts, facets,
                     summary.height_mm);
}

std::string thickness_of(const LayerSummary& layers) {
  const auto um = [](Nanometers thickness) { return to_millimeters(thickness).count() * 1000; };
  if (!layers.adaptive) return fmt::format("{:g} um", um(layers.thinnest));
  return fmt::format("{:g} to {:g} um", um(layers.thinnest), um(layers.thickest));
}

// "1980.3 to 2011.7 ms", or one figure where both are the same.
std::string light_of(const LayerRecord& layer) {
  const std::string most =
      fmt::format("{:.1f} ms{}", milliseconds(layer.exposure_most), layer.dark_confirmed ? "" : " or more");
  const std::string least = fmt::format("{:.1f}", milliseconds(layer.exposure_least));
  return most.starts_with(least + " ") ? most : least + " to " + most;
}

}  // namespace

PrinterService::PrinterService(const PrinterConfig& config, EventLoop& loop, Clock& clock, Machine& machine,
                               const Log& log, Supervisor& supervisor)
    : config_(config),
      loop_(loop),
      clock_(clock),
      machine_(machine),
      log_(log),
      supervisor_(supervisor),
      spool_(config.spool_folder, loop, *this),
      reading_record_(state_folder_path(config.spool_folder) / kReadingRecord),
      process_(machine, clock, *this),
      analyst_(loop),
      archivist_(loop, spool_),
      worker_(loop, kNiceness) {}

PrinterService::~PrinterService() {
  loop_.on_turn_over(nullptr);
}

void PrinterService::start() {
  loop_.on_turn_over([this](const EventLoop::Turn& turn) {
    if (process_.light_may_be_on()) note_lit_turn(turn);
  });
  machine_.on_disturbance([this](const Disturbance& disturbance) { disturbed(disturbance); });
  if (const std::string hindrance = machine_.hindrance(); !hindrance.empty())
    log_.error("machine", fmt::format("the printer cannot print: {}", printable(hindrance)));
  plate_occupant_ = spool_.plate_occupant();
  held_ = spool_.hold();
  if (const std::string trouble = spool_.trouble(); !trouble.empty()) log_.error("spool", printable(trouble));
  find_left_jobs();
  if (held_) log_.warning("held", hold_sentence());
  control_ = std::make_unique<ControlServer>(loop_, config_.control_socket, methods());
  control_->on_call(
      [this](const std::string& method, const ControlServer::Peer& peer) { called(method, peer); });
  spool_.open();
  supervisor_.status(readiness());
  pump_soon();
}

void PrinterService::shut_down(const std::string& reason) {
  shutting_down_ = true;
  reading_record_.stop();
  process_.fail(reason);
  leave_if_over();
}

// Behind a print under way: as long as that ends, the loop must turn for its light.
void PrinterService::leave_if_over() {
  if (!shutting_down_ || process_.state() != PrintState::Idle) return;
  // Printed, and only its analysis still under way.
  if (active_ && active_->over) finish_job();
  if (archivist_.busy()) {
    if (!leave_timer_)
      leave_timer_ = loop_.at(std::chrono::steady_clock::now() + kLongestFiling, "the stop's timer",
                              [this] { stop_waiting_for_filing(); });
    return;
  }
  if (copying_) return spool_.stop_copying();  // the end comes back here
  // Still being read: nothing was printed, so it waits for the next start.
  if (active_) give_back_unbegun();
  if (records_due_) keep_records();
  loop_.stop();
}

// What the archivist is at it still brings to its end, or the next start does.
void PrinterService::stop_waiting_for_filing() {
  const std::string& name = active_->files.name;
  log_.error(
      "stopped",
      fmt::format("{}: not filed after {:.0f} s: the disk does not answer, or this computer is too slow",
                  printable(name), milliseconds(kLongestFiling) / 1000),
      job_fields(name));
  loop_.stop();
}

void PrinterService::give_back_unbegun() {
  const std::string name = active_->files.name;
  try {
    spool_.give_back(active_->files);
    log_.info("stopped", fmt::format("{}: had not begun, waits for the next start", printable(name)),
              job_fields(name));
  } catch (const std::runtime_error& error) {
    log_.error("spool", fmt::format("{}: stays in printing: {}", printable(name), printable(error.what())),
               job_fields(name));
  }
  active_.reset();
}

void PrinterService::disturbed(const Disturbance& disturbance) {
  const bool printing = process_.state() != PrintState::Idle && process_.state() != PrintState::Ending;
  switch (disturbance.kind) {
    case Disturbance::Kind::Fault:
      process_.fail(disturbance.what);
      break;
    case Disturbance::Kind::Interruption:
      process_.interrupt(disturbance.what);
      break;
    case Disturbance::Kind::Recovery:
    case Disturbance::Kind::Notice:
      break;
  }
  const bool bad = disturbance.kind != Disturbance::Kind::Recovery;
  const bool of_print =
      disturbance.kind == Disturbance::Kind::Fault || disturbance.kind == Disturbance::Kind::Interruption;
  // What happens to a print is told with the print.
  if (!of_print || !printing)
    log_.write(bad ? LogLevel::Warning : LogLevel::Info, "machine", printable(disturbance.what));
  for (const std::string& warning : disturbance.warnings)
    log_.warning("machine", printable(warning));
  if (disturbance.owner_decides) hold(disturbance.what);
  if (process_.state() == PrintState::Idle) supervisor_.status(readiness());
  notify("machine", ControlServer::Delivery::Lossy);
  pump_soon();
}

void PrinterService::find_left_jobs() {
  for (const JobFiles& files : spool_.interrupted()) {
    // It had not begun.
    if (plate_occupant_ != files.name && reading_record_.take_ended(files)) {
      left_jobs_.push_back({files, PrintEnd{PrintOutcome::Failed, std::string(kEndedAProcess)}});
      log_.error("refused", fmt::format("{}: {}", printable(files.name), kEndedAProcess),
                 job_fields(files.name));
      continue;
    }
    left_jobs_.push_back({files, recorded_end(spool_, files.name)});
    const std::optional<PrintEnd>& end = left_jobs_.back().end;
    const std::string how =
        end ? fmt::format("contourd did not file this print, which was {}", name_of(end->outcome))
            : "contourd did not end this print";
    log_.error("interrupted", fmt::format("{}: {} (power cut, crash or kill)", printable(files.name), how),
               job_fields(files.name));
    if (!end) plate_occupant_ = files.name;
    if (held_ || (end && end->outcome != PrintOutcome::Failed)) continue;
    held_ = end ? fmt::format("{} failed: {}", files.name, end->reason)
                : fmt::format("{} was interrupted: the power was cut, or contourd was killed or crashed",
                              files.name);
  }
  if (!left_jobs_.empty()) keep_records();
}

void PrinterService::file_left_jobs() {
  while (!left_jobs_.empty()) {
    const auto& [files, end] = left_jobs_.back();
    const Spool::Folder folder = end ? folder_for(end->outcome) : Spool::Folder::Failed;
    move_job(files, folder,
             end ? reason_text(*end)
                 : "The print was interrupted: the power was cut, or contourd was killed or crashed. Put the "
                   "model into incoming again to print it from the start.\n");
    log_.info(
        "interrupted",
        fmt::format("{}: moved to {}", printable(files.name), spool_.folder(folder).filename().string()),
        job_fields(files.name));
    left_jobs_.pop_back();
  }
}

// --- the spool's events

void PrinterService::model_arrived(const std::string& file) {
  const auto same_file = [&](const QueuedJob& job) { return job.file == file; };
  const auto queued = std::find_if(queue_.begin(), queue_.end(), same_file);
  QueuedJob job{.file = file, .arrived = std::chrono::steady_clock::now(), .trouble = {}};
  if (queued != queue_.end()) {
    job.trouble = std::move(queued->trouble);  // told already
    *queued = std::move(job);                  // written again: keeps its place
  } else {
    queue_.push_back(job);
    log_.info("queued", fmt::format("{}: arrived, number {} in the queue", printable(file), queue_.size()),
              file_fields(file));
  }
  pump();
}

void PrinterService::plate_waits(const std::string& file, const std::vector<std::string>& missing) {
  std::string names;
  for (const std::string& name : missing)
    names += (names.empty() ? "" : ", ") + printable(name);
  log_.info("incomplete",
            fmt::format("{}: waits for {}, which its {} names", printable(file), names, kPlateTicket),
            file_fields(file));
}

void PrinterService::passed_over(const std::string& file, Oddity oddity) {
  log_.warning("passed-over", fmt::format("{}: is passed over: {}", printable(file), sentence_for(oddity)),
               file_fields(file));
}

void PrinterService::more_passed_over(std::size_t files) {
  log_.warning("passed-over", fmt::format("{} more in incoming are passed over", files));
}

void PrinterService::incoming_lost(const std::string& why) {
  log_.error("spool",
             fmt::format("nothing arrives until there is an incoming folder again: {}", printable(why)));
}

void PrinterService::incoming_replaced() {
  log_.warning("spool", "incoming was removed, replaced or mounted over: what is there now is watched");
}

void PrinterService::model_withdrawn(const std::string& file) {
  const auto job =
      std::find_if(queue_.begin(), queue_.end(), [&](const QueuedJob& q) { return q.file == file; });
  if (job == queue_.end()) return;
  if (job->check == QueuedJob::Check::Refused) {
    // Most likely the spool took it: rejected() knows.
    job->withdrawn = true;
    return;
  }
  remove_withdrawn(job);
}

void PrinterService::remove_withdrawn(std::deque<QueuedJob>::iterator job) {
  const std::string file = job->file;
  queue_.erase(job);
  log_.info("withdrawn", fmt::format("{}: taken away by the owner", printable(file)), file_fields(file));
  pump();
}

// --- from the queue to a print

void PrinterService::pump_soon() {
  pump_timer_ = loop_.at(std::chrono::steady_clock::now(), "the queue", [this] { pump(); });
}

void PrinterService::retry_later() {
  pump_timer_ = loop_.at(std::chrono::steady_clock::now() + kRetryInterval, "the queue's timer", [this] {
    check_postponed();
    pump();
  });
}

std::string PrinterService::reason_to_wait() const {
  if (std::string hindrance = machine_.hindrance(); !hindrance.empty()) return hindrance;
  if (held_) return hold_sentence();
  if (!left_jobs_.empty())
    return fmt::format("{} is not filed yet: {}", left_jobs_.back().files.name, unkept_);
  if (config_.wait_for_plate_cleared && plate_occupant_) {
    return fmt::format("the plate holds {}; say \"contourctl plate-cleared\" when it is clear",
                       *plate_occupant_);
  }
  if (std::string trouble = spool_.trouble(); !trouble.empty()) return trouble;
  const std::uintmax_t free = spool_.free_bytes();
  if (free < config_.min_free_disk_bytes) {
    return fmt::format("the spool's disk has {} MB free, {} MB are needed", free / 1'000'000,
                       config_.min_free_disk_bytes / 1'000'000);
  }
  return "";
}

std::string PrinterService::readiness() const {
  const std::string hindrance = machine_.hindrance();
  if (!hindrance.empty()) return "Cannot print: " + printable(hindrance);
  return held_ ? "Waits for its owner: " + hold_sentence() : "Ready";
}

std::string PrinterService::hold_sentence() const {
  if (!held_) return "";
  const bool plate_too = config_.wait_for_plate_cleared && plate_occupant_;
  return fmt::format("the queue is held: {}; see to the printer{}, then say \"contourctl {}\"",
                     printable(*held_), plate_too ? " and clear the plate" : "",
                     plate_too ? "plate-cleared" : "resume");
}

void PrinterService::hold(const std::string& why) {
  if (held_) return;
  held_ = why;
  log_.warning("held", hold_sentence());
  keep_records();
}

void PrinterService::let_go() {
  if (!held_) return;
  held_.reset();
  log_.info("held", "the queue goes on: the owner has seen to the printer");
  keep_records();
}

void PrinterService::keep_records() {
  // light_gone() comes back here.
  records_due_ = process_.light_may_be_on();
  if (records_due_) return;
  std::string trouble;
  try {
    spool_.set_plate_occupant(plate_occupant_);
    spool_.set_hold(held_);
    // Last: as long as they lie in printing/, the next start knows what these records would tell it.
    file_left_jobs();
  } catch (const std::system_error& error) {
    trouble = error.what();
    keep_timer_ =
        loop_.at(std::chrono::steady_clock::now() + kRetryInterval, "the queue's timer", [this] { pump(); });
  }
  if (std::exchange(unkept_, trouble) == trouble || trouble.empty()) return;
  log_.error("spool", fmt::format("a restart will not know all that is known now, which is tried again until "
                                  "it is on the disk: {}",
                                  printable(trouble)));
  for (const LeftJob& job : left_jobs_)
    log_.error("spool", fmt::format("{}: stays in printing until then", printable(job.files.name)),
               job_fields(job.files.name));
}

void PrinterService::pump() {
  try {
    const bool try_again = !unkept_.empty() && process_.state() == PrintState::Idle;
    if (records_due_ || try_again) keep_records();
    take_what_is_due();
  } catch (const std::system_error& error) {
    // The spool's disk is gone or full: the queue waits for it.
    const std::string trouble = fmt::format("the spool cannot be used: {}", printable(error.what()));
    if (std::exchange(waiting_for_, trouble) != trouble) log_.error("spool", trouble);
    retry_later();
  }
}

void PrinterService::take_what_is_due() {
  if (shutting_down_) return;
  const std::string reason = active_ || queue_.empty() ? "" : reason_to_wait();
  if (std::exchange(waiting_for_, reason) != reason && !reason.empty()) {
    log_.info("waiting", fmt::format("{} waits: {}", printable(queue_.front().file), printable(reason)));
  }
  if (queue_.empty()) return;
  if (!active_ && reason.empty()) return begin_next();
  queue_.front().waited = true;
  // A disk may get room again without a word.
  if (!reason.empty()) retry_later();
  check_waiting();
}

void PrinterService::begin_next() {
  QueuedJob job = queue_.front();
  // Its check is being made right now, or a refused file looks for a name: the end comes back here.
  if (job.check == QueuedJob::Check::Running || rejections_ > 0 || copying_) return;
  queue_.pop_front();
  // The owner is writing it anew: it comes back when it is whole.
  if (spool_.is_unfinished(job.file)) {
    spool_.wait_for(job.file);
    return pump_soon();
  }
  JobFiles files;
  try {
    job.settings = settings_of(job);
    files = spool_.begin(job.file);
  } catch (const ProfileTrouble& trouble) {
    return wait_for_profile(std::move(job), trouble.sentence());
  } catch (const std::system_error& error) {
    return not_claimed(std::move(job), error);
  }
  claimed(std::move(job), std::move(files));
}

std::optional<JobSettings> PrinterService::settings_of(const QueuedJob& job) const {
  try {
    return read_settings(spool_.files_of(Spool::Folder::Incoming, job.file), config_);
  } catch (const ProfileTrouble& trouble) {
    // One that was there when the job was checked is not its ticket's mistake.
    const bool known = job.check == QueuedJob::Check::Passed;
    if (known || trouble.fault() == ProfileTrouble::Fault::Profile) throw;
    return std::nullopt;
  } catch (const JobRefused&) {
    return std::nullopt;
  }
}

// An owner who mends it says nothing: it is read again.
void PrinterService::wait_for_profile(QueuedJob job, const std::string& why) {
  const std::string trouble = fmt::format("{}; the queue goes on when it is mended", why);
  if (std::exchange(job.trouble, trouble) != trouble)
    log_.error("profile", fmt::format("{} waits: {}", printable(job.file), printable(trouble)),
               file_fields(job.file));
  waiting_for_ = trouble;
  job.waited = true;
  job.check = QueuedJob::Check::Passed;  // as far as that is possible now
  queue_.push_front(std::move(job));
  pump_timer_ =
      loop_.at(std::chrono::steady_clock::now() + kProfileInterval, "the queue's timer", [this] { pump(); });
  check_waiting();
}

void PrinterService::claimed(QueuedJob job, JobFiles files) {
  ActiveJob active;
  active.turn_came = job.waited ? std::chrono::steady_clock::now() : job.arrived;
  active.files = std::move(files);
  active_ = std::move(active);
  active_->settings = std::move(job.settings);
  read_active();
  // Whoever copied it may not have had it written to the disk, and after a power cut it would be empty. After
  // preparing it: the first mask does not wait for the disk.
  worker_.run(
      [files = active_->files] {
        sync_contents(files.model);
        if (files.ticket) sync_contents(*files.ticket);
        return true;
      },
      [](bool) {});
}

// It is tried again until it is taken away: a disk may be well again without a word.
void PrinterService::not_claimed(QueuedJob job, const std::system_error& error) {
  if (!spool_.is_waiting(job.file)) {
    log_.info("withdrawn", fmt::format("{}: taken away by the owner", printable(job.file)),
              file_fields(job.file));
    return pump_soon();
  }
  if (Spool::is_immovable(error.code())) return begin_with_copy(std::move(job), error.code().message());
  const std::string trouble =
      fmt::format("{} cannot be claimed: {}", printable(job.file), printable(error.what()));
  if (std::exchange(job.trouble, trouble) != trouble) log_.error("claim", trouble, file_fields(job.file));
  waiting_for_ = trouble;
  job.waited = true;
  queue_.push_front(std::move(job));
  retry_later();
}

void PrinterService::begin_with_copy(QueuedJob job, const std::string& why) {
  copying_ = std::move(job);
  spool_.begin_with_copy(copying_->file, [this, why](const Spool::Copy& copy) { copied(copy, why); });
}

void PrinterService::copied(const Spool::Copy& copy, const std::string& why) {
  QueuedJob job = std::move(*copying_);
  copying_.reset();
  if (copy.job) {
    log_.warning("copied",
                 fmt::format("{}: a copy of it is printed, as it cannot be moved: {}{}", printable(job.file),
                             why, copy.job->original.empty() ? "" : "; what lies in incoming may be deleted"),
                 file_fields(job.file));
    claimed(std::move(job), *copy.job);
  } else if (!copy.unreadable.empty()) {
    queue_.push_front(std::move(job));
    reject(queue_.front(), printable_lines(shortened(copy.unreadable, kLongestReason)));
  } else {
    const std::string trouble =
        fmt::format("{} cannot be copied: {}", printable(job.file), printable(copy.trouble));
    if (std::exchange(job.trouble, trouble) != trouble) log_.error("claim", trouble, file_fields(job.file));
    waiting_for_ = trouble;
    job.waited = true;
    // What is about this job alone keeps no other waiting.
    queue_.push_back(std::move(job));
    if (queue_.front().trouble.empty())
      pump_soon();
    else
      retry_later();
  }
  leave_if_over();
}

void PrinterService::reject(QueuedJob& job, const std::string& reason) {
  job.check = QueuedJob::Check::Refused;
  ++rejections_;
  spool_.reject(job.file, reason + "\n",
                [this, file = job.file, reason](Spool::Rejection rejection, const std::string& trouble) {
                  rejected(file, reason, rejection, trouble);
                });
}

void PrinterService::rejected(const std::string& file, const std::string& reason, Spool::Rejection rejection,
                              const std::string& trouble) {
  --rejections_;
  const auto job = std::find_if(queue_.begin(), queue_.end(), [&](const QueuedJob& q) {
    return q.file == file && q.check == QueuedJob::Check::Refused;
  });
  if (rejection == Spool::Rejection::Unfinished) {
    // It comes back when it is whole, and is checked then.
    if (job == queue_.end()) return pump();
    if (job->withdrawn) return remove_withdrawn(job);
    job->check = QueuedJob::Check::Passed;
    return pump();
  }
  if (job != queue_.end()) queue_.erase(job);
  log_.error("refused", fmt::format("{}: {}", printable(file), reason), file_fields(file));
  if (rejection == Spool::Rejection::LeftThere)
    log_.warning(
        "refused",
        fmt::format("{}: lies in incoming still, as it cannot be moved; it may be deleted", printable(file)),
        file_fields(file));
  if (rejection == Spool::Rejection::Impossible)
    log_.error("refused",
               fmt::format("{}: cannot be moved to failed: {}", printable(file), printable(trouble)));
  ended(job_name_of(file), "failed", reason);
  pump();
}

void PrinterService::prepared(std::variant<PreparedJob, Refusal> result) {
  const std::string name = active_->files.name;
  const auto* refusal = std::get_if<Refusal>(&result);
  if (refusal != nullptr && read_later(*refusal)) return;
  if (refusal != nullptr || active_->cancel_wanted || shutting_down_) {
    const std::string reason = refusal != nullptr ? refusal->reason : "cancelled before it started";
    log_.error("refused", fmt::format("{}: {}", printable(name), reason), job_fields(name));
    file_job(active_->files, Spool::Folder::Failed, reason + "\n");
    active_.reset();
    ended(name, refusal != nullptr ? "failed" : "cancelled", reason);
    return pump_soon();
  }
  active_->prepared = std::move(std::get<PreparedJob>(result));
  const JobSummary& summary = active_->prepared->summary;
  log_.info("ready",
            fmt::format("{}: {}, {} layers of {}; first mask after {:.0f} ms", printable(name),
                        content_of(summary), summary.layers.count, thickness_of(summary.layers),
                        milliseconds(active_->prepared->first_mask_at - active_->turn_came)),
            job_fields(name));
  log_.info("settings", fmt::format("{}: {}", printable(name), describe_settings(summary)), job_fields(name));
  if (const std::string correction = describe_correction(summary); !correction.empty()) {
    log_.info("compensation", fmt::format("{}: {}", printable(name), correction), job_fields(name));
  }
  const std::size_t told = std::min(summary.warnings.size(), kMostWarnings);
  for (std::size_t i = 0; i < told; ++i)
    log_.warning("model", fmt::format("{}: {}", printable(name), summary.warnings[i]), job_fields(name));
  if (told < summary.warnings.size())
    log_.warning("model", fmt::format("{}: and {} more", printable(name), summary.warnings.size() - told),
                 job_fields(name));
  start_print();
}

void PrinterService::start_print() {
  const std::string name = active_->files.name;
  try {
    active_->masks = machine_.begin_job(name);
  } catch (const std::system_error& error) {
    const std::string reason = printable(error.what());
    log_.error("refused", fmt::format("{}: {}", printable(name), reason), job_fields(name));
    file_job(active_->files, Spool::Folder::Failed, reason + "\n");
    active_.reset();
    ended(name, "failed", reason);
    return pump_soon();
  }
  active_->started = clock_.now();
  active_->late_steps_then = machine_.z_axis().late_steps().count;
  active_->started_at = std::chrono::system_clock::now();
  start_analysis();
  process_.start(std::move(active_->prepared->plan));
  // It may have come while the model was read.
  if (const std::string hindrance = machine_.hindrance(); !hindrance.empty()) {
    process_.interrupt(hindrance);
  } else if (held_) {
    process_.interrupt(*held_);
  }
}

void PrinterService::start_analysis() {
  PreparedJob& job = *active_->prepared;
  AnalysisTask task{std::move(job.analysis_engine), job.display, job.plan.expected_layers, {}, job.analysis};
  for (std::size_t layer = 0; layer < task.layers.size(); ++layer)
    task.layer_durations.push_back(
        layer_duration(job.plan, static_cast<std::int32_t>(layer), machine_.z_axis()));
  analyst_.start(std::move(task), [this](AnalyzedPrint print) { analyzed(std::move(print)); });
}

void PrinterService::analyzed(AnalyzedPrint print) {
  const std::string name = active_->files.name;
  if (auto* const findings = std::get_if<PrintFindings>(&print.findings)) {
    log_.info("analysis",
              fmt::format("{}: {}; found in {:.0f} ms", printable(name), findings_line(*findings),
                          milliseconds(print.took)),
              job_fields(name));
    for (const std::string& warning : warnings_about(*findings)) {
      log_.warning("analysis", fmt::format("{}: {}", printable(name), warning), job_fields(name));
    }
    active_->analysis = findings_summary_json(*findings);
    active_->findings = std::move(*findings);
  } else {
    log_.warning("analysis",
                 fmt::format("{}: the print goes on, but could not be analysed: {}", printable(name),
                             std::get<std::string>(print.findings)),
                 job_fields(name));
  }
  notify("analysis", ControlServer::Delivery::Lossy);
  if (active_->over) finish_job();
}

// --- the print's events

void PrinterService::state_changed(PrintState state) {
  if (printing_) printing_(state != PrintState::Idle);
  // Told to the disk before the first light: from there on the plate is not clear, whatever happens next.
  if (state == PrintState::Showing && active_->layers.empty()) set_plate_occupant(active_->files.name);
  constexpr PrintState kWorthALine[] = {PrintState::WarmingUp, PrintState::Homing, PrintState::Paused,
                                        PrintState::Parking};
  if (active_ && std::find(std::begin(kWorthALine), std::end(kWorthALine), state) != std::end(kWorthALine)) {
    log_.info("state", fmt::format("{}: {}", printable(active_->files.name), name_of(state)),
              job_fields(active_->files.name));
  }
  notify("state", ControlServer::Delivery::Lossy);
}

void PrinterService::layer_done(const LayerRecord& layer) {
  active_->layers.push_back(layer);
  const std::int32_t count = active_->prepared->summary.layers.count;
  LogFields fields = job_fields(active_->files.name);
  fields.emplace_back("LAYER", std::to_string(layer.layer + 1));
  fields.emplace_back("Z_NM", std::to_string(layer.plate_height.count()));
  log_.info("layer",
            fmt::format("layer {} of {}: height {:.4f} mm, {:.2f} mm2, {} loops, mask {:.2f} ms, light {}{}",
                        layer.layer + 1, count, to_millimeters(layer.plate_height).count(), layer.area_mm2,
                        layer.loops, milliseconds(layer.mask_time), light_of(layer),
                        layer.complete ? "" : ", not finished"),
            fields);
  warn_about_light(layer, fields);
  if (layer.cracks.open_chains > 0) {
    log_.warning("gaps",
                 fmt::format("layer {}: {} contours did not close; the widest gap bridged is {:.3f} mm",
                             layer.layer + 1, layer.cracks.open_chains, layer.cracks.widest_gap.count()),
                 fields);
  }
  if (layer.cracks.turned_chains > 0) {
    log_.warning(
        "turned",
        fmt::format("layer {}: {} stretches of contours are turned against the others; they were turned back",
                    layer.layer + 1, layer.cracks.turned_chains),
        fields);
  }
  if (layer.area_mm2 == 0 && layer.layer + 1 < count) {
    log_.warning("empty", fmt::format("layer {}: nothing to expose", layer.layer + 1), fields);
  }
  supervisor_.status(
      fmt::format("Printing {}, layer {} of {}", printable(active_->files.name), layer.layer + 1, count));
  notify("layer", ControlServer::Delivery::Lossy);
}

void PrinterService::warn_about_light(const LayerRecord& layer, const LogFields& fields) {
  const auto asked = fmt::format("layer {}: the light was on for {}, {:.1f} ms were asked for",
                                 layer.layer + 1, light_of(layer), milliseconds(layer.exposure_asked));
  // By more than a refresh: something kept this process from turning the light off.
  if (layer.exposure_least > layer.exposure_asked + machine_.display().frame())
    log_.warning("overexposed", asked, fields);
  const Duration tolerated = active_->prepared->summary.resin.tolerance.bounds;
  if (layer.exposure_most - layer.exposure_least > tolerated) {
    log_.warning("doubtful-light",
                 fmt::format("{}; the projector's answers tell no better, the resin tolerates {:.0f} ms",
                             asked, milliseconds(tolerated)),
                 fields);
  }
}

void PrinterService::interrupted(const std::string& what) {
  const std::string name = active_->files.name;
  const std::string place = fmt::format("layer {}", process_.layer() + 1);
  active_->interruptions.push_back(fmt::format("{}: {}", place, what));
  LogFields fields = job_fields(name);
  fields.emplace_back("LAYER", std::to_string(process_.layer() + 1));
  log_.warning("disturbed",
               fmt::format("{}: {}: {}; {}; \"contourctl resume\" goes on with what the layer lacks",
                           printable(name), place, printable(what),
                           machine_.projector().doubt().empty() ? "the light is off" : "light off is sent"),
               fields);
  supervisor_.status(fmt::format("Interrupted at {} of {}: {}", place, printable(name), printable(what)));
}

void PrinterService::light_gone() {
  note_lit_turn(loop_.turn());
  if (records_due_) pump_soon();
}

void PrinterService::note_lit_turn(const EventLoop::Turn& turn) {
  if (active_ && turn.busy > active_->busiest_lit.busy) active_->busiest_lit = turn;
}

void PrinterService::print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) {
  const std::string name = active_->files.name;
  PrintReport report = make_report(outcome, reason);
  const std::string summary =
      fmt::format("{}: {} after {} of {} layers and {}{}", printable(name), name_of(outcome),
                  layers_exposed(report.layers), report.summary.layers.count, readable(report.print_time),
                  reason.empty() ? "" : ": " + reason);
  log_.write(outcome == PrintOutcome::Failed ? LogLevel::Error : LogLevel::Info, name_of(outcome), summary,
             job_fields(name));
  warn_about_lateness(report);
  archivist_.record(name, {outcome, reason});
  active_->over = EndedPrint{active_->files, std::move(report), std::move(plan.engine)};
  // What is wrong with the machine would be wrong for the next job too, and that begins with a motion.
  // Stopped with contourd, it has left its part in the way.
  if (outcome == PrintOutcome::Failed) hold(fmt::format("{} failed: {}", name, reason));
  // A print on a machine takes much longer than its analysis; a simulated one need not.
  if (outcome == PrintOutcome::Done && analyst_.busy() && !shutting_down_) return;
  finish_job();
  leave_if_over();
}

void PrinterService::warn_about_lateness(const PrintReport& report) {
  if (report.late_steps > 0) {
    log_.warning(
        "late",
        fmt::format("{}: {} steps of the motor came late and shifted those behind them: this computer "
                    "was too busy for them, or is too slow",
                    printable(report.job), report.late_steps),
        job_fields(report.job));
  }
  const EventLoop::Turn& turn = report.busiest_lit;
  if (turn.busy > kLongestLitTurn) {
    log_.warning(
        "busy",
        fmt::format(
            "{}: {} kept the event loop busy for {:.1f} ms, of which {:.1f} ms were computing, while the "
            "light was on or not known to be off; {:.0f} ms are the limit: light off may have come "
            "that much later",
            printable(report.job), turn.source, milliseconds(turn.busy), milliseconds(turn.computing),
            milliseconds(kLongestLitTurn)),
        job_fields(report.job));
  }
}

void PrinterService::finish_job() {
  analyst_.cancel();
  EndedPrint print = std::move(*active_->over);
  active_->over.reset();
  print.report.findings = std::move(active_->findings);
  archivist_.file(std::move(print), [this](const FiledPrint& done) { filed(done); });
}

void PrinterService::filed(const FiledPrint& print) {
  const std::string& name = print.files.name;
  for (const std::string& trouble : print.troubles)
    log_.error("spool", fmt::format("{}: {}", printable(name), printable(trouble)), job_fields(name));
  Json analysis = std::move(active_->analysis);
  active_.reset();
  check_postponed();
  if (!print.moved) {
    left_jobs_.push_back({print.files, PrintEnd{print.outcome, print.reason}});
    keep_records();
  }
  ended(name, name_of(print.outcome), print.reason, std::move(analysis));
  pump_soon();
  leave_if_over();
}

PrintReport PrinterService::make_report(PrintOutcome outcome, const std::string& reason) {
  PrintReport report;
  report.job = active_->files.name;
  report.printer = config_.name;
  report.outcome = outcome;
  report.reason = reason;
  report.summary = std::move(active_->prepared->summary);
  report.layers = std::move(active_->layers);
  report.interruptions = std::move(active_->interruptions);
  report.started = active_->started_at;
  report.ended = std::chrono::system_clock::now();
  report.print_time = clock_.now() - active_->started;
  report.late_steps = late_steps_of_job();
  report.busiest_lit = active_->busiest_lit;
  report.first_mask_after = active_->prepared->first_mask_at - active_->turn_came;
  report.masks = active_->masks;
  return report;
}

// An axis that was lost and opened again counts anew.
std::uint64_t PrinterService::late_steps_of_job() const {
  const std::uint64_t now = machine_.z_axis().late_steps().count;
  return now >= active_->late_steps_then ? now - active_->late_steps_then : now;
}

void PrinterService::file_job(const JobFiles& files, Spool::Folder to, const std::string& reason) {
  try {
    move_job(files, to, reason);
  } catch (const std::system_error& error) {
    log_.error("spool",
               fmt::format("{}: stays in printing: {}", printable(files.name), printable(error.what())),
               job_fields(files.name));
  }
}

void PrinterService::move_job(const JobFiles& files, Spool::Folder to, const std::string& reason) {
  std::string trouble;
  try {
    if (!reason.empty()) spool_.write_beside(to, files.name, "reason.txt", reason);
  } catch (const std::system_error& error) {
    trouble = error.what();  // a full disk has no room for a reason, but a rename needs none
  }
  if (!spool_.end(files, to))
    log_.error("spool", fmt::format("{} is gone: somebody took it away", printable(files.model.string())),
               job_fields(files.name));
  if (!trouble.empty())
    log_.error("spool", fmt::format("{}: no reason beside it: {}", printable(files.name), printable(trouble)),
               job_fields(files.name));
}

void PrinterService::ended(const std::string& name, std::string_view outcome, const std::string& reason,
                           Json analysis) {
  ended_.push_back({name, std::string(outcome), reason, std::move(analysis)});
  if (ended_.size() > kLongestHistory) ended_.pop_front();
  supervisor_.status(fmt::format("{}; last job {}: {}", readiness(), printable(name), outcome));
  notify("ended", ControlServer::Delivery::Certain);
}

// Whatever is wrong with the socket, a print does not suffer from it.
void PrinterService::notify(const std::string& what, ControlServer::Delivery delivery) {
  try {
    if (control_ && control_->is_watched()) control_->notify(what, status(), delivery);
  } catch (const std::exception& error) {
    log_.warning("control", fmt::format("the control socket failed: {}", error.what()));
  }
}

void PrinterService::set_plate_occupant(const std::optional<std::string>& job) {
  plate_occupant_ = job;
  spool_.set_plate_occupant(job);
}

}  // namespace contourd
