#include "daemon/ctl/models/slice_files.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "daemon/ctl/terminal/exit_codes.hpp"

namespace contourd::ctl {
namespace {

void write_file(const std::filesystem::path& path, const fmt::memory_buffer& text) {
  write_text(path, {text.data(), text.size()});
}

}  // namespace

void write_text(const std::filesystem::path& path, std::string_view text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) throw OutputError(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
}

void write_measurements(const std::filesystem::path& path, std::span<const LayerMeasurement> layers) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "layer,z_mm,slicing_ms,contour_ms,total_ms,intersecting_facets,loop_count\n");
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const LayerMeasurement& l = layers[i];
    fmt::format_to(out, "{},{:.6f},{:.6f},{:.6f},{:.6f},{},{}\n", i + 1, l.z.count(), l.slicing_ms,
                   l.contour_ms, l.total_ms(), l.intersecting_facets, l.loop_count);
  }
  write_file(path, text);
}

void write_statistics(const std::filesystem::path& path, const LayerStatistics& statistics) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  const auto row = [&out](std::string_view name, const MeanAndDeviation& values) {
    fmt::format_to(out, "{},{:.6f},{:.6f}\n", name, values.mean, values.deviation);
  };
  fmt::format_to(out, "measurement,mean,standard_deviation\n");
  row("slicing_ms", statistics.slicing_ms);
  row("contour_ms", statistics.contour_ms);
  row("total_ms", statistics.total_ms);
  row("intersecting_facets", statistics.intersecting_facets);
  row("loop_count", statistics.loop_count);
  fmt::format_to(out, "normalized_correlation_contour_time_vs_loop_count,{:.6f},\n",
                 statistics.contour_time_vs_loop_count);
  fmt::format_to(out, "normalized_correlation_contour_time_vs_intersecting_facets,{:.6f},\n",
                 statistics.contour_time_vs_intersecting_facets);
  write_file(path, text);
}

void write_contours(const std::filesystem::path& path, const Contours& contours, const PixelMap& map) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "loop,x_mm,y_mm,x_pixel,y_pixel\n");
  for (std::size_t loop = 0; loop < contours.loops.size(); ++loop) {
    for (const Point& point : contours.points_of(contours.loops[loop])) {
      const PixelPoint pixel = map.to_pixels(point);
      fmt::format_to(out, "{},{:.6f},{:.6f},{:.3f},{:.3f}\n", loop + 1, point.x, point.y, pixel.x, pixel.y);
    }
  }
  write_file(path, text);
}

}  // namespace contourd::ctl
