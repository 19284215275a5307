#include "daemon/jobs/current_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/prepare/print_findings.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/print/print_modes.hpp"
#include "daemon/report/plate_copies.hpp"
#include "daemon/spool/job_filing.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// The memory of a print returns to the system some moments after its end, so a job that finds too little is
// read again: this many attempts in all, with this time between two of them.
constexpr int kMaxReadings = 5;
constexpr double kMm3PerMl = 1000;
constexpr Duration kReadingInterval = 1s;

// Returns the task of the job's analysis, and moves the analysis engine into it.
AnalysisTask analysis_of(PreparedJob& job, const ZAxis& axis) {
  return {std::move(job.analysis_engine), job.display, job.plan.expected_layers,
          layer_durations(job.plan, axis), job.analysis};
}

// Returns why a job with a finding that always needs confirmation is refused: no user was asked, because it
// was not checked before its turn or its resin was changed meanwhile. Empty if there is no such finding.
std::string why_unaccepted(const PreparedJob& job, const std::vector<std::string>& accepted) {
  const auto analysis = analysis_of_preparation(job.summary);
  if (!analysis) return "";
  const auto finding = std::ranges::find_if(analysis->findings, [&](const std::string& each) {
    return std::ranges::find(accepted, each) == accepted.end();
  });
  if (finding == analysis->findings.end()) return "";
  if (*finding == kWideGaps)
    return job.summary.wide_gaps + "; fix the model, or print it with \"cracks\": \"repair\" in its ticket";
  if (*finding == kToBeConfirmed)
    return "its ticket has it wait (\"confirm\": true); put it into incoming again, and it waits for "
           "\"contourctl accept\"";
  const std::string found = *finding == kUnitInDoubt       ? job.summary.unit_question
                            : *finding == kSupportsInDoubt ? job.summary.supports_question
                            : *finding == kLeftOutModels   ? job.summary.left_out
                                                           : unheld_sentence(job.summary.supports->unheld);
  return found + "; put it into incoming again, and it waits for \"contourctl accept\"";
}

// Returns the light that a print's split exposures gave; null if none was split.
std::unique_ptr<GivenLight> given_light(const PrintPlan& plan, const std::vector<LayerRecord>& layers,
                                        Duration frame) {
  if (!plan.split) return nullptr;
  std::vector<double> shortest;
  for (const LayerRecord& layer : layers)
    shortest.push_back(SplitExposure::shortest_share(layer.exposure_asked, frame));
  return std::make_unique<GivenLight>(plan.split->panel(), std::move(shortest));
}

// Returns the print's report; moves the record and the summary out of the job.
PrintReport report_of(CurrentJob::State& job) {
  PrintReport report = job.record->take_report();
  report.job = job.claimed.files.name;
  report.summary = std::move(job.prepared->summary);
  report.forecast = job.forecast;
  report.first_mask_after = job.prepared->first_mask_at - job.claimed.turn_came;
  return report;
}

// Returns what users changed in a print while it printed; empty if that is nothing.
std::string changes_of(std::span<const SettingChange> changes, std::span<const Exclusion> exclusions) {
  std::string text = describe(changes);
  constexpr std::size_t kMost = 20;
  for (const Exclusion& each : exclusions.first(std::min(exclusions.size(), kMost)))
    text += (text.empty() ? "" : "; ") + describe(each);
  if (exclusions.size() > kMost) text += fmt::format("; and {} more", exclusions.size() - kMost);
  return text;
}

// Returns the figures of a print under way. Its interruptions and late steps are known only at its end.
JobFigures figures_of(const JobSummary& summary, const std::vector<LayerRecord>& layers,
                      const std::string& changes, Duration print_time) {
  JobFigures figures{.resin = summary.resin.name,
                     .settings = describe_settings(summary) + (changes.empty() ? "" : "; " + changes),
                     .warnings = summary.warnings,
                     .height_mm = summary.height_mm,
                     .layers = summary.layers.count,
                     .layers_exposed = layers_exposed(layers),
                     .print_time_s = in_seconds(print_time)};
  Duration lit{}, asked{}, most_over{};
  for (const LayerRecord& layer : layers) {
    lit += layer.exposure_most;
    asked += layer.exposure_asked;
    most_over = std::max(most_over, layer.exposure_most - layer.exposure_asked);
  }
  const double volume_mm3 = exposed_volume_mm3(layers);
  if (!layers.empty()) figures.layer_height_um = to_millimeters(layers.front().thickness).count() * 1000;
  figures.lit_s = in_seconds(lit);
  figures.light_asked_s = in_seconds(asked);
  figures.most_light_over_ms = milliseconds(most_over);
  figures.resin_ml = volume_mm3 / kMm3PerMl;
  return figures;
}

// Returns the figures of a print that is over.
JobFigures figures_of(const PrintReport& report) {
  JobFigures figures = figures_of(report.summary, report.layers,
                                  changes_of(report.changes, report.exclusions), report.print_time);
  if (report.findings) {
    for (const std::string& warning : warnings_about(*report.findings))
      figures.warnings.push_back(warning);
  }
  figures.interruptions =
      static_cast<std::int64_t>(report.stops.interruptions.size() + report.stops.more_interruptions);
  figures.late_steps = static_cast<std::int64_t>(report.late_steps);
  return figures;
}

}  // namespace

CurrentJob::CurrentJob(const PrinterContext& context, Spool& spool, JobReader& reader, QueueHold& hold,
                       HistoryWorker& history, JobObserver& observer)
    : context_(context),
      spool_(spool),
      reader_(reader),
      hold_(hold),
      history_(history),
      observer_(observer),
      log_(context.log),
      print_(make_print_mode(context.machine, context.clock, *this)),
      analyst_(context.loop),
      archivist_(context.loop, spool, context.config.memory_limit_bytes),
      progress_(context.loop, context.log, progress_file(context.config.spool_folder),
                [this] { return print_->light_may_be_on(); }),
      frames_(context.loop, frames_file(context.config.spool_folder)),
      speeds_(context.loop, "contourd-speeds") {
  context_.loop.on_turn_over([this](const EventLoop::Turn& turn) {
    if (print_->light_may_be_on()) add_lit_turn(turn);
  });
}

CurrentJob::~CurrentJob() {
  context_.loop.on_turn_over(nullptr);
}

bool CurrentJob::finishing() const {
  return job_ && job_->record && !print_->under_way();
}

void CurrentJob::add_lit_turn(const EventLoop::Turn& turn) {
  if (job_ && job_->record) job_->record->add_lit_turn(turn);
}

// --- before the print

void CurrentJob::begin(ClaimedJob job) {
  expects(!job_, "there is no job yet");
  job_.emplace(std::move(job));
  job_->key = history_.begin(name());
  read();
  // The program that copied the file may not have synced it, and after a power cut it would be empty. Synced
  // after the preparation, so that the first mask does not wait for the disk.
  reader_.sync(job_->claimed.files);
}

void CurrentJob::read() {
  reader_.read(job_->claimed.files, job_->claimed.settings,
               [this](ReadJob result) { was_read(std::move(result)); });
}

void CurrentJob::was_read(ReadJob result) {
  if (job_->leaving) return;
  const bool unwanted = job_->cancel_wanted || stopping_;
  if (const auto* refusal = std::get_if<JobRefusal>(&result)) {
    if (unwanted || !refusal->for_now || ++job_->readings >= kMaxReadings)
      return refuse(PrintOutcome::Failed, refusal->reason);
    // There was too little memory; more may be free soon.
    const TimePoint later = std::chrono::steady_clock::now() + kReadingInterval;
    read_timer_ = context_.loop.at(later, "a job's timer", [this] {
      if (job_ && !job_->leaving) read();
    });
    return;
  }
  if (unwanted || std::holds_alternative<ReadingGivenUp>(result))
    return refuse(PrintOutcome::Canceled, "cancelled before it started");
  auto& prepared = std::get<PreparedJob>(result);
  if (const std::string why = why_unaccepted(prepared, job_->claimed.accepted); !why.empty())
    return refuse(PrintOutcome::Failed, why);
  job_->prepared = std::move(prepared);
  log_.ready(name(), job_->prepared->summary, job_->prepared->first_mask_at - job_->claimed.turn_came);
  occupy_plate();
}

JobEnd CurrentJob::end_as(PrintOutcome outcome, const std::string& reason) const {
  return {.key = job_->key,
          .job = name(),
          .outcome = std::string(name_of(outcome)),
          .reason = reason,
          .ended = std::chrono::system_clock::now()};
}

// Leaves a print that cannot go on after a power cut to the user: its part still hangs on the plate.
void CurrentJob::wait_again(const std::string& reason) {
  context_.log.error("interrupted",
                     fmt::format("{}: the print does not go on: {}", printable(name()), printable(reason)),
                     job_fields(name()));
  job_->leaving = true;
  history_.forget();
  InterruptedPrint print = job_->claimed.resumed->print;
  print.trouble = reason;
  // The caller still uses the job.
  spool_.run([] { return true; },
             [this, print = std::move(print)](bool) {
               job_.reset();
               hold_.set_interrupted(print);
               observer_.job_changed("state");
               observer_.may_stop();
             });
}

void CurrentJob::refuse(PrintOutcome outcome, const std::string& reason) {
  if (job_->claimed.resumed) return wait_again(reason);
  log_.refused(name(), reason);
  job_->leaving = true;
  JobEnd end = end_as(outcome, reason);
  end.kind = JobEnd::Kind::Refused;
  const auto troubles = std::make_shared<std::vector<std::string>>();
  spool_.keep(
      [troubles, end, &spool = spool_, files = job_->claimed.files](const StateRecords&) {
        try {
          spool.ends().add(end);
        } catch (const std::system_error&) {
          // A full disk has no room for the record, but a rename needs none.
        }
        *troubles = move_job(spool, files, Spool::Folder::Failed, end.reason + "\n");
      },
      [this, troubles, end](const std::string& why_it_stays) {
        for (const std::string& trouble : *troubles)
          context_.log.error("spool", trouble, job_fields(name()));
        refusal_filed(end, why_it_stays);
      });
}

void CurrentJob::refusal_filed(const JobEnd& end, const std::string& why_it_stays) {
  const JobFiles files = std::move(job_->claimed.files);
  job_.reset();
  if (!why_it_stays.empty()) {
    context_.log.error(
        "spool", fmt::format("{}: stays in printing: {}", printable(files.name), printable(why_it_stays)),
        job_fields(files.name));
    hold_.add_unfiled(files, end);
  }
  EndedJob ended = ended_job(end);
  history_.end(ended);
  observer_.job_ended(std::move(ended));
  observer_.may_stop();
}

void CurrentJob::cancel() {
  expects(job_.has_value(), "there is a job");
  if (job_->record) return print_->cancel();
  job_->cancel_wanted = true;
  reader_.give_up_reading();
}

void CurrentJob::stop(const std::string& reason) {
  stopping_ = true;
  print_->fail(reason);
}

void CurrentJob::give_back() {
  expects(job_ && !job_->record, "there is a job that has not begun");
  job_->leaving = true;
  history_.forget();
  // The next start finds in printing/ what a power cut ended.
  if (job_->claimed.resumed)
    return spool_.run([] { return true; },
                      [this](bool) {
                        job_.reset();
                        observer_.may_stop();
                      });
  if (job_->prepared) hold_.set_plate_occupant(job_->plate_before);
  spool_.give_back(job_->claimed.files, [this](const std::string& trouble) { given_back(trouble); });
}

void CurrentJob::given_back(const std::string& trouble) {
  const std::string job = name();
  job_.reset();
  if (trouble.empty())
    context_.log.info(
        "stopped",
        fmt::format("{}: not started yet; waits in incoming for the next start of contourd", printable(job)),
        job_fields(job));
  else
    context_.log.error("spool", fmt::format("{}: stays in printing: {}", printable(job), printable(trouble)),
                       job_fields(job));
  observer_.may_stop();
}

// --- the print

// Saves on the disk before anything moves that the plate is not clear, whatever happens to the print.
void CurrentJob::occupy_plate() {
  job_->plate_before = hold_.plate_occupant();
  hold_.set_plate_occupant(name(), [this](const std::string& trouble) {
    if (job_ && !job_->leaving) plate_saved(trouble);
  });
}

void CurrentJob::plate_saved(const std::string& trouble) {
  if (!job_->cancel_wanted && !stopping_ && trouble.empty()) return start_print();
  hold_.set_plate_occupant(job_->plate_before);
  if (trouble.empty()) return refuse(PrintOutcome::Canceled, "cancelled before it started");
  refuse(PrintOutcome::Failed,
         "cannot record that the plate is not clear from now on: " + printable(trouble));
}

// Returns why the prepared job is not the one whose print a power cut ended; empty if it is, or if no power
// cut ended a print of it.
std::string CurrentJob::why_not_continued() const {
  if (!job_->claimed.resumed) return "";
  const std::int32_t layers = job_->claimed.resumed->print.progress.layers;
  const std::size_t now = job_->prepared->plan.expected_layers.size();
  const bool is_as_high =
      job_->prepared->plan.layers.thickness_at(job_->claimed.resumed->point.bottom).has_value();
  if (now == static_cast<std::size_t>(layers) && is_as_high) return "";
  if (!is_as_high) return "its model has no layer above the last one";
  return fmt::format("the job has {} layers now, and had {} when its print began: restore the printer's file",
                     now, layers);
}

void CurrentJob::start_print() {
  Machine& machine = context_.machine;
  std::optional<std::filesystem::path> masks;
  if (const std::string why = why_not_continued(); !why.empty()) return refuse(PrintOutcome::Failed, why);
  try {
    masks = machine.begin_job(name());
  } catch (const std::system_error& error) {
    hold_.set_plate_occupant(job_->plate_before);
    return refuse(PrintOutcome::Failed, printable(error.what()));
  }
  job_->record.emplace(machine, context_.clock, std::move(masks));
  if (job_->claimed.resumed) go_on();
  job_->forecast = forecast_of(job_->prepared->plan, context_.config);
  analyst_.start(analysis_of(*job_->prepared, machine.z_axis()),
                 [this](AnalyzedPrint print) { analyzed(std::move(print)); });
  if (!job_->claimed.resumed) record_progress();
  print_->start(std::move(job_->prepared->plan));
  if (job_->rise_settings && print_->rises_ahead())
    set_rises(*job_->rise_settings, [this](const std::string& refusal) {
      if (!refusal.empty()) context_.log.warning("set", refusal, {});
    });
  // The machine may have become unready, or the queue held, while the model was read.
  if (const std::string not_ready = machine.why_not_ready(); !not_ready.empty()) {
    print_->interrupt(not_ready);
  } else if (const std::optional<std::string>& held = hold_.reason()) {
    print_->interrupt(*held);
  }
}

// Lets the print go on where a power cut ended it, and marks the seam in the report and the history.
void CurrentJob::go_on() {
  const JobProgress& progress = job_->claimed.resumed->print.progress;
  PreparedJob& prepared = *job_->prepared;
  prepared.plan.resume = job_->claimed.resumed->point;
  const std::optional<CureSettings>& cure = prepared.settings.resin.cure;
  const std::string seam =
      describe_seam(progress, cure ? std::optional(cure->curve.penetration_depth) : std::nullopt);
  prepared.summary.warnings.push_back(seam);
  job_->record->add_interruption(prepared.plan.resume->layer, seam);
  take_changes(progress.changes);
  context_.log.warning("resumed", fmt::format("{}: {}", printable(name()), seam), job_fields(name()));
  progress_.go_on(progress);
  hold_.release();
}

// Takes over what was changed in the print before a power cut ended it.
void CurrentJob::take_changes(const JobProgress::Changes& changes) {
  PrintPlan& plan = job_->prepared->plan;
  const std::int32_t layer = plan.resume->layer;
  PrintSettings settings{plan.exposure_percent, plan.motion,
                         plan.rises ? plan.rises->settings : RiseSettings{}};
  const RiseSettings planned = settings.rise;
  for (std::size_t i = 0; i < changes.settings.size(); ++i) {
    if (is_of_rises(kPrintSettings[i])) {
      settings = with_value(settings, kPrintSettings[i], changes.settings[i]);
      continue;
    }
    const double value = changes.settings[i], before = value_of(settings, kPrintSettings[i]);
    if (value == before) continue;
    job_->record->add(SettingChange{layer, kPrintSettings[i], value, before});
    settings = with_value(settings, kPrintSettings[i], value);
  }
  plan.exposure_percent = settings.exposure_percent;
  plan.motion = settings.motion;
  if (plan.rises && settings.rise != planned) job_->rise_settings = settings.rise;
  const JobSummary& summary = job_->prepared->summary;
  const std::vector<PlateCopy> copies = copies_of(summary, name());
  std::set<std::size_t> excluded;
  for (const std::uint32_t number : changes.excluded) {
    if (number >= copies.size() || !excluded.insert(number).second) continue;
    const PlateCopy& copy = copies[number];
    job_->record->add(Exclusion{number, copy.name, layer});
    leave_dark(plan, {copy.model, copy.copy, supports_left(summary.supports, copies, excluded)}, 0,
               Nanometers{});
  }
}

void CurrentJob::record_changes() {
  const PrintRecord& record = *job_->record;
  JobProgress::Changes changes;
  if (!record.changes().empty()) {
    for (const std::string_view setting : kPrintSettings)
      changes.settings.push_back(value_of(print_->settings(), setting));
  }
  for (const Exclusion& each : record.exclusions())
    changes.excluded.push_back(static_cast<std::uint32_t>(each.number));
  progress_.change(std::move(changes));
}

void CurrentJob::record_progress() {
  const PrintPlan& plan = job_->prepared->plan;
  JobProgress progress{.job = name(), .layers = static_cast<std::int32_t>(plan.expected_layers.size())};
  progress.print.thickness = plan.expected_layers.front();
  progress_.begin(std::move(progress),
                  [&config = context_.config, files = job_->claimed.files,
                   resin = job_->prepared->settings.resin.name] { return marks_of(files, resin, config); });
}

void CurrentJob::analyzed(AnalyzedPrint print) {
  log_.analyzed(name(), print);
  if (auto* const findings = std::get_if<PrintFindings>(&print.findings)) {
    job_->analysis = findings_summary_json(*findings);
    job_->findings = std::move(*findings);
  }
  observer_.job_changed("analysis");
  if (job_->over) file();
}

void CurrentJob::set(std::string_view setting, double value) {
  expects(print_->under_way(), "a print is under way");
  record_change(setting, value, std::nullopt);
  print_->set(with_value(print_->settings(), setting, value));
  record_changes();
}

// Records a change that is about to be made.
void CurrentJob::record_change(std::string_view setting, double value, std::optional<Nanometers> height) {
  const std::int32_t layer = print_->layer() + (height ? 0 : 1);
  const SettingChange change{layer, setting, value, value_of(print_->settings(), setting), height};
  job_->record->add(change);
  context_.log.info("set", fmt::format("{}: {}", printable(name()), describe(change)), job_fields(name()));
}

void CurrentJob::set_rises(const RiseSettings& settings,
                           std::function<void(const std::string& refusal)> done) {
  std::optional<RisesAhead> ahead = print_->rises_ahead();
  expects(ahead.has_value(), "a rise is left");
  if (std::exchange(job_->plans_rises, true))
    return done("the speeds of the last change are still being planned: try again in a second");
  const auto planned = std::make_shared<const RisesAhead>(std::move(*ahead));
  speeds_.run([planned, settings] { return change_rises(*planned, settings); },
              [this, planned, key = job_->key,
               done = std::move(done)](const std::variant<ChangedRises, std::string>& result) {
                if (!job_ || job_->key != key) return done("the print has ended, and nothing was changed");
                job_->plans_rises = false;
                rises_planned(*planned, result, done);
              });
}

// Changes the rises, if the print is where it was expected to be.
void CurrentJob::rises_planned(const RisesAhead& planned,
                               const std::variant<ChangedRises, std::string>& result,
                               const std::function<void(const std::string& refusal)>& done) {
  if (const auto* const refusal = std::get_if<std::string>(&result)) return done(*refusal);
  const auto& changed = std::get<ChangedRises>(result);
  const std::optional<RisesAhead> ahead = print_->rises_ahead();
  if (!ahead || ahead->each.size() != planned.each.size() ||
      ahead->height.has_value() != planned.height.has_value() ||
      (ahead->height && *ahead->height > *changed.from))
    return done("the plate has gone on before its speeds were planned, and nothing was changed: try again");
  PrintSettings settings = print_->settings();
  settings.rise = changed.settings;
  for (const std::string_view setting : kPrintSettings) {
    if (!is_of_rises(setting)) continue;
    const double value = value_of(settings, setting);
    if (value != value_of(print_->settings(), setting)) record_change(setting, value, ahead->height);
  }
  // The plate's way on from now counts, not from when the speeds began to be planned.
  if (changed.settings != print_->settings().rise) job_->record->add(changed_forecast(*ahead, changed));
  print_->change(changed);
  record_changes();
  done("");
}

void CurrentJob::exclude(std::size_t number) {
  expects(print_->under_way(), "a print is under way");
  const JobSummary& summary = job_->prepared->summary;
  const std::vector<PlateCopy> copies = copies_of(summary, name());
  expects(number < copies.size(), "there is such a copy");
  std::set<std::size_t> excluded{number};
  for (const Exclusion& each : job_->record->exclusions())
    excluded.insert(each.number);
  const PlateCopy& copy = copies[number];
  const Exclusion exclusion{number, copy.name, print_->layer() + 1};
  job_->record->add(exclusion);
  print_->exclude({copy.model, copy.copy, supports_left(summary.supports, copies, excluded)});
  record_changes();
  context_.log.info("exclude", fmt::format("{}: {}", printable(name()), describe(exclusion)),
                    job_fields(name()));
}

void CurrentJob::light_due() {
  job_->had_light = !job_->prepared->summary.dry;
}

void CurrentJob::state_changed(const PrintState& state) {
  observer_.print_state_changed(state);
  if (job_) {
    if (job_->record) job_->record->enter(state, state == kIdle ? 0 : print_->layer());
    log_.entered(name(), state);
  }
  observer_.job_changed("state");
}

void CurrentJob::layer_done(const LayerRecord& layer) {
  job_->record->add(layer);
  lit_ += layer.exposure_most;
  observer_.resin_used(exposed_volume_mm3({&layer, 1}) / kMm3PerMl);
  const JobSummary& summary = job_->prepared->summary;
  log_.layer(name(), summary, layer, context_.machine.display().frame());
  context_.supervisor.status(
      fmt::format("Printing {}, layer {} of {}", printable(name()), layer.layer + 1, summary.layers.count));
  const PrintRecord& record = *job_->record;
  history_.note([&] {
    return figures_of(summary, record.layers(), changes_of(record.changes(), record.exclusions()),
                      record.elapsed());
  });
  observer_.job_changed("layer");
}

void CurrentJob::warned(const std::string& what) {
  context_.log.warning("peel", fmt::format("{}: {}", printable(name()), what), job_fields(name()));
  job_->warnings.push_back(what);
  observer_.job_changed("state");
}

void CurrentJob::interrupted(const std::string& what) {
  job_->record->add_interruption(print_->layer(), what);
  log_.interrupted(name(), print_->layer(), what,
                   context_.machine.projector().light_off_unconfirmed().empty());
  context_.supervisor.status(fmt::format("Interrupted at layer {} of {}: {}", print_->layer() + 1,
                                         printable(name()), printable(what)));
}

void CurrentJob::light_gone() {
  add_lit_turn(context_.loop.turn());
}

// --- after the print

void CurrentJob::print_ended(PrintOutcome outcome, const std::string& reason, PrintPlan plan) {
  PrintReport report = report_of(*job_);
  report.printer = context_.config.name;
  report.outcome = outcome;
  report.reason = reason;
  log_.ended(report);
  job_->ended = ended_job(end_as(outcome, reason));
  job_->ended.figures = figures_of(report);
  const JobEnd end = job_end(job_->ended);
  archivist_.record(end);
  progress_.end();
  std::unique_ptr<GivenLight> given = given_light(plan, report.layers, context_.machine.display().frame());
  job_->over = EndedPrint{
      job_->claimed.files, std::move(report), std::move(plan.engine), std::move(plan.undersides), end,
      std::move(given)};
  job_->over->frames = frames_.end();
  if (!job_->had_light) hold_.set_plate_occupant(job_->plate_before);
  // A fault of the machine would hit the next job too, which begins with a motion. A print that was stopped
  // with contourd has left its part in the way.
  if (outcome == PrintOutcome::Failed) hold_.hold(fmt::format("{} failed: {}", name(), reason));
  // A real print takes much longer than its analysis; a simulated one may not.
  if (outcome == PrintOutcome::Done && analyst_.busy() && !stopping_) return;
  file();
  observer_.may_stop();
}

void CurrentJob::stop_analysis() {
  if (job_ && job_->over) file();
}

void CurrentJob::file() {
  analyst_.cancel();
  EndedPrint print = std::move(*job_->over);
  job_->over.reset();
  print.report.findings = std::move(job_->findings);
  job_->ended.analysis = job_->analysis;
  job_->ended.figures = figures_of(print.report);
  history_.end(job_->ended);
  print.held = hold_.last_attempt();
  archivist_.file(std::move(print), [this](const FiledPrint& done) { filed(done); });
}

void CurrentJob::filed(const FiledPrint& print) {
  const std::string& name = print.files.name;
  for (const std::string& trouble : print.troubles)
    context_.log.error("spool", fmt::format("{}: {}", printable(name), printable(trouble)), job_fields(name));
  EndedJob ended = std::move(job_->ended);
  job_.reset();
  if (!print.moved) hold_.add_unfiled(print.files, print.end);
  ended.reports = print.reports;
  observer_.job_ended(std::move(ended));
  observer_.may_stop();
}

}  // namespace contourd
