#include "daemon/jobs/job_reader.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <exception>
#include <fstream>
#include <iterator>
#include <span>
#include <utility>

#include "daemon/jobs/acceptances.hpp"
#include "daemon/prepare/job_memory.hpp"
#include "daemon/prepare/resin_temperature.hpp"
#include "daemon/report/job_picture.hpp"
#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/state_records.hpp"
#include "daemon/system/checksum.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Reading a model during a print gives way to the event loop.
constexpr int kReaderNiceness = 5;
constexpr std::size_t kLongestReason = 8000;
// Time to analyze the layers of a job that a user is to accept, with an empty ask_before.
constexpr Duration kLongestAnalysis = std::chrono::seconds(30);
constexpr const char* kGivenUp = "another job had to be read first; try again";
// In the state folder: see reading_record.hpp.
constexpr const char* kReadingRecord = "reading";

}  // namespace

JobMarks marks_of(const JobFiles& files, const std::string& resin, const PrinterConfig& config) {
  std::ifstream profile(config.resins_folder / (resin + ".json"), std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(profile), {});
  text += fmt::format(" {} {} {} {} {} {} {} {} {} {} {} {} {}", config.display_width.count(),
                      config.display_height.count(), config.pixel_pitch.count(), config.mirror_x,
                      config.mirror_y, config.anti_aliasing, config.grey_bits, config.irradiance_mw_cm2,
                      config.tone.gamma, config.tone.threshold, config.gamma_of_light,
                      static_cast<int>(config.supports), config.simulated.axis.microsteps_per_mm);
  std::uint64_t settings = checksum_of(text);
  if (config.uniformity) {
    const std::span<const std::uint8_t> pixels = config.uniformity->pixels();
    settings = checksum_of({reinterpret_cast<const char*>(pixels.data()), pixels.size()}, settings);
  }
  return {content_mark(files), settings};
}

JobReader::JobReader(const PrinterConfig& config, Spool& spool, EventLoop& loop)
    : config_(config),
      spool_(spool),
      record_(std::make_shared<ReadingRecord>(state_folder_path(config.spool_folder) / kReadingRecord)),
      worker_(loop, "contourd-reader", kReaderNiceness) {}

JobReader::~JobReader() {
  give_up();
}

void JobReader::stop() {
  spool_.run(
      [record = record_] {
        record->stop();
        return true;
      },
      [](bool) {});
  give_up();
}

void JobReader::give_up() {
  reading_.request_stop();
  give_up_inspections();
}

void JobReader::give_up_inspections() {
  for (Inspection& inspection : inspections_)
    inspection.stop.request_stop();
}

ReadJob JobReader::read_now(const JobFiles& files, const std::optional<JobSettings>& settings,
                            const std::stop_token& stop) {
  if (record_->take_ended(files)) return JobRefusal{std::string(kEndedAProcess)};
  const ReadingRecord::Reading under_way(*record_, files);
  ReadJob job = prepare(files, settings, stop);
  const auto* const refusal = std::get_if<JobRefusal>(&job);
  if (refusal == nullptr || !refusal->for_now || cache_.empty()) return job;
  // The cached job gives way.
  cache_.drop();
  return prepare(files, settings, stop);
}

ReadJob JobReader::prepare(const JobFiles& files, const std::optional<JobSettings>& settings,
                           const std::stop_token& stop) {
  try {
    auto job = prepare_job(files, settings ? *settings : read_settings(files, config_), config_, stop);
    if (!job) return ReadingGivenUp{};
    follow_temperature(*job, config_);
    return std::move(*job);
  } catch (const JobTooLarge& refusal) {
    return JobRefusal{refusal_text(refusal.what()), refusal.fits_alone()};
  } catch (const ProfileTrouble& trouble) {
    const bool of_profile = trouble.fault() == ProfileTrouble::Fault::Profile;
    return JobRefusal{refusal_text(trouble.what()), false, of_profile ? trouble.sentence() : ""};
  } catch (const JobRefused& refusal) {
    return JobRefusal{refusal_text(refusal.what())};
  }
}

void JobReader::read(const JobFiles& files, const std::optional<JobSettings>& settings,
                     std::function<void(ReadJob)> done) {
  give_up_inspections();
  reading_ = std::stop_source();
  worker_.run(
      [this, files, settings, stop = reading_.get_token()]() -> ReadJob {
        std::optional<PreparedJob> cached = cache_.take(files, settings);
        if (!cached) return read_now(files, settings, stop);
        follow_temperature(*cached, config_);
        return std::move(*cached);
      },
      std::move(done));
}

template <typename InspectNow, typename Done>
void JobReader::inspect(const std::string& file, InspectNow inspect_now, Done done) {
  const auto inspection = inspections_.insert(inspections_.end(), Inspection{file});
  worker_.run(
      [this, file, inspect_now, stop = inspection->stop.get_token()]() {
        return inspect_now(spool_.files_of(Spool::Folder::Incoming, file), stop);
      },
      [this, inspection, done = std::move(done)](const auto& found) {
        inspections_.erase(inspection);
        done(found);
      });
}

void JobReader::check(const std::string& file, Keep keep, std::function<void(const CheckedJob&)> done) {
  if (keep == Keep::Prepared) give_up_inspections();
  inspect(
      file,
      [this, keep](const JobFiles& files, const std::stop_token& stop) {
        return check_now(files, keep, stop);
      },
      std::move(done));
}

CheckedJob JobReader::check_now(const JobFiles& files, Keep keep, const std::stop_token& stop) {
  if (stop.stop_requested()) return ReadingGivenUp{};
  if (keep == Keep::Prepared) cache_.drop();
  const std::string mark = mark_of(files), content = content_mark(files);
  ReadJob job = read_now(files, std::nullopt, stop);
  if (std::holds_alternative<ReadingGivenUp>(job)) return ReadingGivenUp{};
  if (auto* refusal = std::get_if<JobRefusal>(&job)) return std::move(*refusal);
  auto& prepared = std::get<PreparedJob>(job);
  JobOutlook outlook = outlook_of(prepared, files, config_);
  std::optional<PreprintAnalysis> found = analysis_of_preparation(prepared.summary);
  // A user who is to accept the job wants to know its resin and its findings, too. With ask_before, all jobs
  // are analyzed after their checks.
  if (prepared.summary.confirm && config_.ask_before.empty()) {
    const ReadingRecord::Reading under_way(*record_, files);
    found = analyze_within(kLongestAnalysis, prepared, config_, stop);
    if (!found) return ReadingGivenUp{};
  }
  if (found) outlook.question = AnalyzedJob{std::move(*found), content, prepared.settings};
  if (keep == Keep::Prepared) cache_.keep(files, mark, std::move(prepared));
  return outlook;
}

void JobReader::analyze(const std::string& file, Keep keep,
                        std::function<void(const JobAnalysisOutcome&)> done) {
  inspect(
      file,
      [this, keep](const JobFiles& files, const std::stop_token& stop) {
        return analyze_now(files, keep, stop);
      },
      std::move(done));
}

JobAnalysisOutcome JobReader::analyze_now(const JobFiles& files, Keep keep, const std::stop_token& stop) {
  if (stop.stop_requested()) return ReadingGivenUp{};
  const std::string mark = mark_of(files), content = content_mark(files);
  ReadJob read = keep == Keep::Prepared ? take_or_read(files, stop) : read_now(files, std::nullopt, stop);
  if (std::holds_alternative<ReadingGivenUp>(read)) return ReadingGivenUp{};
  if (auto* refusal = std::get_if<JobRefusal>(&read)) return std::move(*refusal);
  auto& job = std::get<PreparedJob>(read);
  std::optional<PreprintAnalysis> analysis;
  {
    const ReadingRecord::Reading under_way(*record_, files);
    analysis = analyze_before_print(job, config_, stop);
  }
  if (!analysis) return ReadingGivenUp{};
  AnalyzedJob analyzed{std::move(*analysis), content, job.settings};
  if (keep == Keep::Prepared) cache_.keep(files, mark, std::move(job));
  return analyzed;
}

void JobReader::try_settings(const std::string& file, const JobSettings& settings,
                             std::function<void(const std::string& refusal)> done) {
  inspect(
      file,
      [this, settings](const JobFiles& files, const std::stop_token& stop) -> std::string {
        const ReadJob read = stop.stop_requested() ? ReadingGivenUp{} : read_now(files, settings, stop);
        if (std::holds_alternative<ReadingGivenUp>(read)) return kGivenUp;
        const auto* const refusal = std::get_if<JobRefusal>(&read);
        return refusal != nullptr ? refusal->reason : "";
      },
      std::move(done));
}

void JobReader::draw(const std::string& file, std::function<void(const DrawnJob&)> done) {
  inspect(
      file, [this](const JobFiles& files, const std::stop_token& stop) { return draw_now(files, stop); },
      std::move(done));
}

DrawnJob JobReader::draw_now(const JobFiles& files, const std::stop_token& stop) {
  // The preparation of the next job stays cached.
  const bool was_cached = cache_.has(files);
  const std::string mark = mark_of(files);
  ReadJob read = stop.stop_requested() ? ReadingGivenUp{}
                 : was_cached          ? take_or_read(files, stop)
                                       : read_now(files, std::nullopt, stop);
  if (std::holds_alternative<ReadingGivenUp>(read)) return {{}, kGivenUp};
  if (const auto* const refusal = std::get_if<JobRefusal>(&read)) return {{}, refusal->reason};
  auto& job = std::get<PreparedJob>(read);
  const Supports* const supports = job.summary.supports ? &*job.summary.supports : nullptr;
  DrawnJob drawn;
  try {
    const ReadingRecord::Reading under_way(*record_, files);
    drawn.png = encode_picture(draw_job(*job.plan.engine, supports), supports).png;
  } catch (const std::exception& error) {
    drawn.trouble = printable(error.what());
  }
  if (was_cached) cache_.keep(files, mark, std::move(job));
  return drawn;
}

// Takes the preparation that the check has cached, or reads the job again.
ReadJob JobReader::take_or_read(const JobFiles& files, const std::stop_token& stop) {
  try {
    if (std::optional<PreparedJob> cached = cache_.take(files, read_settings(files, config_)))
      return std::move(*cached);
  } catch (const JobRefused&) {
    // read_now() reports the reason.
  }
  return read_now(files, std::nullopt, stop);
}

void JobReader::forget(const std::string& file) {
  for (Inspection& inspection : inspections_)
    if (inspection.file == file) inspection.stop.request_stop();
  worker_.run(
      [this, file] {
        cache_.forget(spool_.files_of(Spool::Folder::Incoming, file));
        return true;
      },
      [](bool) {});
}

void JobReader::save(Record record, const std::vector<std::string>& lines,
                     std::function<void(const std::string&)> done) {
  spool_.keep(
      [record, lines](const StateRecords& records) {
        record == Record::Order ? records.keep_queue_order(lines) : records.keep_accepted(lines);
      },
      std::move(done));
}

void JobReader::sync(const JobFiles& files) {
  worker_.run(
      [files] {
        sync_contents(files.model);
        if (files.ticket) sync_contents(*files.ticket);
        return true;
      },
      [](bool) {});
}

std::string refusal_text(std::string_view why) {
  return printable_lines(shortened(why, kLongestReason));
}

}  // namespace contourd
