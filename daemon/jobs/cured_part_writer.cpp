#include "daemon/jobs/cured_part_writer.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/report/job_picture.hpp"
#include "daemon/report/plate_copies.hpp"
#include "daemon/report/print_frames.hpp"
#include "daemon/report/print_report_html.hpp"
#include "daemon/report/print_report_json.hpp"
#include "daemon/report/printed_light.hpp"
#include "daemon/system/memory_room.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr int kCuringNiceness = 15;
constexpr std::chrono::minutes kLongestCuring{10};
constexpr std::chrono::seconds kLongestCuredMask{5};
// Memory that stays free for the next print.
constexpr std::uint64_t kMemoryLeft = 100'000'000;
// Bytes for each pixel of the models' box: doses, and lines through models and part.
constexpr std::uint64_t kBytesPerPixel = 100;
// Bytes for each crossing of a line with a surface: the crossing, its stretch, the distance there, and the
// room that growing arrays leave unused.
constexpr std::uint64_t kBytesPerCrossing = 60;
// More crossings take more than a gigabyte of memory beside the next print.
constexpr std::uint64_t kMostCrossings = 20'000'000;

// Watches the limits of a computation.
class CureLimits {
 public:
  explicit CureLimits(std::optional<std::uint64_t> memory) : memory_(memory) {}

  // Returns the reason why the computation may not go on; empty if it may. `more`: bytes that it needs.
  [[nodiscard]] std::string exceeded(std::uint64_t more) const {
    if (SteadyClock::now() > end_)
      return fmt::format("this takes longer than {} minutes", kLongestCuring.count());
    const MemoryRoom room = memory_room(memory_);
    if (room.bytes < more + kMemoryLeft)
      return fmt::format("this needs more memory than there is: {} are free, {}", megabytes(room.bytes),
                         room.reason);
    return "";
  }

 private:
  std::optional<std::uint64_t> memory_;
  SteadyClock::time_point end_ = SteadyClock::now() + kLongestCuring;
};

// Returns about how many crossings with the models' surfaces CureComparison finds: of vertical lines through
// all pixels, and of lines along rows and columns of pixels.
std::uint64_t crossings_of(std::span<const PlateModel> models, double pixel_mm) {
  double crossings = 0;
  for (const PlateModel& model : models) {
    const Bounds& bounds = model.model->bounds();
    const double height_mm = static_cast<double>(bounds.max_z) - static_cast<double>(bounds.min_z);
    const double beside_mm2 = pixel_mm * height_mm / CureComparison::kWallLayers;
    double of_copy = 0;
    for (const Facet& facet : model.model->facets()) {
      const Vertex &a = facet.vertices[0], &b = facet.vertices[1], &c = facet.vertices[2];
      // The facet's area as seen from above, and along x and y.
      const auto area = [&](float Vertex::*u, float Vertex::*v) {
        return std::abs(static_cast<double>(b.*u - a.*u) * static_cast<double>(c.*v - a.*v) -
                        static_cast<double>(b.*v - a.*v) * static_cast<double>(c.*u - a.*u)) /
               2;
      };
      of_copy += area(&Vertex::x, &Vertex::y) / (pixel_mm * pixel_mm) +
                 (area(&Vertex::y, &Vertex::z) + area(&Vertex::x, &Vertex::z)) / beside_mm2;
    }
    crossings += of_copy * static_cast<double>(model.copies.size());
  }
  return static_cast<std::uint64_t>(std::min(crossings, 1e15));
}

// Returns the memory of the supports that each excluded copy leaves standing.
std::uint64_t memory_of_supports(const PrintReport& report) {
  constexpr std::uint64_t kBytesPerPrimitive = 120;
  const std::optional<Supports>& supports = report.summary.supports;
  if (!supports || !supports->structure) return 0;
  return kBytesPerPrimitive * supports->structure->primitives().size() * report.exclusions.size();
}

std::uint64_t most_memory(const ContourEngine& engine, const DisplayGeometry& display,
                          const JobSummary& summary, std::size_t layers, std::uint64_t crossings) {
  const ResinProfile& resin = summary.resin;
  const PixelLight& pixel = summary.pixel_light;
  const bool remembers_all = resin.cure->peel_memory == 1 && resin.cure->oxygen_dose.count() == 0;
  constexpr std::size_t kMostLayers = 400;  // whose light reaches a layer
  const std::uint64_t per_pixel = kBytesPerPixel +
                                  (pixel.gaussians.empty() ? 0 : LightSpread::kBytesPerPixel) +
                                  (remembers_all ? 0 : sizeof(std::uint16_t) * std::min(layers, kMostLayers));
  return per_pixel * window_of(engine.models(), display, pixel.reach() + 1).pixels() +
         kBytesPerCrossing * crossings;
}

// Returns into how many steps a rise may be divided: each takes two masks, and a share of kLongestRise.
std::size_t most_steps(const std::vector<LayerRecord>& layers) {
  constexpr std::size_t kMost = 20'000, kFewest = 500;
  constexpr std::chrono::minutes kLongestRise{3};
  Duration mask{};
  std::int64_t slices = 0;
  for (const LayerRecord& layer : layers) {
    if (!layer.rises) continue;
    mask += layer.frames.longest_cut;
    ++slices;
  }
  if (mask <= Duration{0}) return kMost;
  return std::clamp(static_cast<std::size_t>(Duration(kLongestRise) / 2 * slices / mask), kFewest, kMost);
}

// True if a file still has this text. Throws UnreadableFile; never waits for a writer of the file.
bool has_text(const std::filesystem::path& path, std::string_view text) {
  const FileDescriptor file = open_regular_file(path, Links::Follow);
  std::string found(text.size() + 1, '\0');
  std::size_t size = 0;
  while (size < found.size()) {
    const ssize_t more = ::read(file.get(), found.data() + size, found.size() - size);
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) break;
    size += static_cast<std::size_t>(more);
  }
  found.resize(size);
  return found == text;
}

}  // namespace

CuredPartWriter::CuredPartWriter(EventLoop& loop, const Spool& spool,
                                 std::optional<std::uint64_t> memory_limit)
    : spool_(spool), memory_limit_(memory_limit), worker_(loop, "contourd-curing", kCuringNiceness) {}

CuredPartWriter::~CuredPartWriter() {
  if (stop_) *stop_ = Stop::Contourd;
}

void CuredPartWriter::begin(std::shared_ptr<PrintToCure> print) {
  stop();
  stop_ = std::make_shared<std::atomic<Stop>>(Stop::No);
  worker_.run(
      [&spool = spool_, limit = memory_limit_, stop = stop_, print = std::move(print)] {
        try {
          write(spool, *print, *stop, limit);
        } catch (const std::exception&) {
          // The report stays as it was filed.
        }
        return true;
      },
      [](bool) {});
}

void CuredPartWriter::stop() {
  if (stop_) *stop_ = Stop::NextPrint;
}

void CuredPartWriter::write(const Spool& spool, PrintToCure& print, const std::atomic<Stop>& stop,
                            std::optional<std::uint64_t> memory_limit) {
  PrintReport& report = print.report;
  if (!report.cured || stop == Stop::Contourd) return;
  const std::string filed = report_as_json(report);
  PrintedPart cured = cure(print, spool.folder(print.folder), stop, memory_limit);
  if (stop == Stop::Contourd) return;
  const ReportFiles files = spool.reports_of(print.folder, report.job);
  if (files.json.empty() || !has_text(files.json, filed)) return;
  report.cured = std::move(cured);
  if (!files.html.empty())
    spool.write_beside(print.folder, report.job, "report.html", report_as_html(report));
  spool.write_beside(print.folder, report.job, "report.json", report_as_json(report));
}

PrintedPart CuredPartWriter::cure(PrintToCure& print, const std::filesystem::path& folder,
                                  const std::atomic<Stop>& stop, std::optional<std::uint64_t> memory_limit) {
  const PrintReport& report = print.report;
  PrintFrames frames = read_print_frames(
      report.layers, report.frames ? folder / report.frames->name : std::filesystem::path());
  const std::optional<PrintedLight> light =
      printed_light(report.layers, report.summary.irradiance_mw_cm2,
                    {frames.records, *report.summary.resin.cure, most_steps(report.layers)});
  if (!light) return {{}, "its layers do not lie one upon another from the first one on"};
  ContourEngine& engine = *print.engine;
  const DisplayGeometry display =
      display_of(engine.models(), engine.coverage().width(), engine.coverage().height());
  const std::uint64_t crossings = crossings_of(engine.models(), to_millimeters(display.pixel_pitch).count());
  if (crossings > kMostCrossings)
    return {{},
            fmt::format("its surface is too large: {} million places would be compared, at most {} million "
                        "are; contourctl cure --report has no such limit",
                        crossings / 1'000'000, kMostCrossings / 1'000'000)};
  const CureLimits limits(memory_limit);
  std::string why_not =
      limits.exceeded(most_memory(engine, display, report.summary, light->layers.size(), crossings) +
                      memory_of_supports(report));
  if (!why_not.empty()) return {{}, why_not};
  try {
    const std::vector<DarkCopy> dark = dark_copies(report.exclusions, copies_of(report.summary, report.job),
                                                   report.summary.supports, *light);
    PrintCure cure(engine, display,
                   {.layers = light->layers,
                    .cure = *report.summary.resin.cure,
                    .pixel = report.summary.pixel_light,
                    .undersides = print.undersides ? &print.undersides->dimming() : nullptr,
                    .mask_heights = light->mask_heights,
                    .is_stopped =
                        [&] {
                          if (why_not.empty() && stop != Stop::No) why_not = "the next print ended before";
                          if (why_not.empty()) why_not = limits.exceeded(0);
                          return !why_not.empty();
                        },
                    .given = print.given.get(),
                    .dark = dark},
                   kLongestCuredMask);
    std::optional<CuredPart> part =
        cure.compare(report.summary.supports ? &*report.summary.supports : nullptr);
    if (!part) return {{}, why_not};
    part->unfound_undersides = layers_with_unfound_undersides(report.layers);
    if (part->weakest_bond > 0) part->weakest_bond_layer = layer_of(*light, part->weakest_bond_layer);
    return {std::move(part), "", light->rise, std::move(frames.why_none)};
  } catch (const std::exception& error) {
    return {{}, error.what()};
  }
}

std::optional<PrintedPart> part_to_come(const PrintReport& report) {
  const JobSummary& summary = report.summary;
  if (!summary.resin.cure || report.layers.empty() || summary.dry || summary.sliced) return std::nullopt;
  return PrintedPart{{},
                     "contourd computes it after the report, and has not finished; contourctl cure --report "
                     "computes it, too"};
}

}  // namespace contourd
