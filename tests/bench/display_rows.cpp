#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <random>
#include <span>
#include <vector>

#include "hw/drm/frame_writer.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/stopwatch.hpp"

namespace contourd::bench {
namespace {

constexpr Pixels kWidth{1920}, kHeight{1080};
constexpr double kTargetMs = 1.0;

// Two masks that differ in the same number of neighbouring pixels in every row, starting at a different
// column in each: no two rows are equal, which is the most work for that amount of change.
std::array<Mask, 2> masks_that_differ_by(double part) {
  std::array<Mask, 2> masks{Mask(kWidth, kHeight), Mask(kWidth, kHeight)};
  const auto length = static_cast<std::size_t>(part * kWidth.count());
  std::mt19937_64 random(kSeed);
  for (std::int32_t y = 0; y < kHeight.count(); ++y) {
    const std::span<std::uint8_t> a = masks[0].row(y), b = masks[1].row(y);
    for (std::size_t x = 0; x < a.size(); ++x)
      a[x] = b[x] = static_cast<std::uint8_t>(random());
    const std::size_t from = random() % (a.size() - length + 1);
    for (std::size_t x = from; x < from + length; ++x)
      b[x] = static_cast<std::uint8_t>(a[x] + 1);
  }
  return masks;
}

// Memory for a picture, like a buffer of a graphics card.
struct Picture {
  explicit Picture(PixelFormat format)
      : stride_bytes(static_cast<std::size_t>(kWidth.count()) * bytes_per_pixel(format)),
        memory(stride_bytes * static_cast<std::size_t>(kHeight.count())) {}
  std::size_t stride_bytes;
  std::vector<std::byte> memory;
};

// The method to beat: converts every pixel of every frame.
void write_all(const Mask& mask, Picture& picture) {
  auto* to = reinterpret_cast<std::uint32_t*>(picture.memory.data());
  for (const std::uint8_t grey : mask.pixels())
    *to++ = xrgb8888(grey);
}

Row row_of(const Bench& bench, int percent) {
  const auto masks = masks_that_differ_by(percent / 100.0);
  Picture ours(PixelFormat::Xrgb8888), all(PixelFormat::Xrgb8888);
  FrameWriter writer({kWidth, kHeight, ours.stride_bytes, PixelFormat::Xrgb8888}, ours.memory);
  writer.write(masks[1]);
  std::size_t next = 0, bytes = 0;
  const Times times = time_runs(bench.runs(400), [&] { bytes = writer.write(masks[next++ % 2]); });
  const Times peer = time_runs(bench.runs(400), [&] { write_all(masks[next++ % 2], all); });

  Row row{fmt::format("display-{}", percent),
          fmt::format("a mask 1920x1080 into a picture, {} % changed, p50", percent), "ms"};
  row.figure = median(times.wall_s) * 1e3;
  row.cpu = median(times.cpu_s) * 1e3;
  if (percent <= 10) row.target = Target{Target::Kind::AtMost, kTargetMs};
  row.peers.push_back({"every pixel", median(peer.wall_s) * 1e3, false, median(peer.cpu_s) * 1e3});
  row.note = fmt::format("{} bytes a frame of {}; p99 {:.3f} ms", bytes, ours.memory.size(),
                         percentile(times.wall_s, 99) * 1e3);
  return row;
}

}  // namespace

std::vector<Row> display_rows(const Bench& bench) {
  std::vector<Row> rows;
  for (const int percent : {1, 10, 100})
    rows.push_back(row_of(bench, percent));
  return rows;
}

}  // namespace contourd::bench
