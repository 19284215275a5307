#include "daemon/frames/frame_log.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>

#include "daemon/frames/frame_file.hpp"
#include "daemon/frames/frame_ring.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/time_limit.hpp"

namespace {

FrameRecord frame_at(std::int64_t height_um) {
  return {.cut = Nanometers{height_um * 1000}, .lit = std::chrono::milliseconds(16), .refreshes = 1};
}

class FrameLogFixture {
 public:
  void add(std::int64_t from, std::int64_t to) {
    for (std::int64_t each = from; each < to; ++each)
      frame_log.add(frame_at(each));
  }
  [[nodiscard]] std::int64_t bytes_on_disk() const {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    return error ? 0 : static_cast<std::int64_t>(size);
  }
  EndedFrameLog end() {
    const auto ended = frame_log.end();
    REQUIRE(ended.wait_for(testing::kTimeLimit) == std::future_status::ready);
    return ended.get();
  }

  testing::TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "print-frames";
  EventLoop loop;
  FrameLog frame_log{loop, path};
};

}  // namespace

TEST_CASE_METHOD(FrameLogFixture,
                 "The frames of a long rise reach the file in their order while it goes on") {
  std::int64_t added = 0;
  REQUIRE(testing::run_loop_until(loop, [&] {
    if (bytes_on_disk() < (added - 511) * 32) return false;  // a last block that is not whole waits
    add(added, added + 100);
    added += 100;
    return added == 10'100;
  }));
  const EndedFrameLog ended = end();
  CHECK(ended.file == path);
  CHECK(ended.recorded == 10'100);
  CHECK(ended.lost == 0);
  CHECK(ended.trouble.empty());
  const FrameFile file = read_frame_file(path);
  CHECK(file.complete);
  REQUIRE(file.records.size() == 10'100);
  for (std::size_t each = 0; each < file.records.size(); ++each)
    if (file.records[each].cut != frame_at(static_cast<std::int64_t>(each)).cut) FAIL(each);
}

TEST_CASE_METHOD(FrameLogFixture, "Each print has a file of its own, and one without frames has none") {
  add(0, 5);
  CHECK(end().recorded == 5);
  add(0, 3);
  CHECK(end().recorded == 3);
  CHECK(read_frame_file(path).records.size() == 3);
  CHECK(end().file.empty());
}

TEST_CASE("The file of a print that a power cut ended is removed at the start") {
  testing::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "print-frames";
  std::ofstream(path) << "torn";
  EventLoop loop;
  FrameLog frame_log(loop, path);
  CHECK(frame_log.end().get().file.empty());
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("Frames for which there is no room in the ring are lost and counted, and adding never waits") {
  testing::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "print-frames";
  EventLoop loop;
  FrameLog frame_log(loop, path);
  // The loop does not turn, so that only the first write is asked for, of at least one block. What that
  // write leaves fills the ring.
  const std::int64_t added = 3 * std::int64_t{FrameRing::kRoom};
  for (std::int64_t each = 0; each < added; ++each)
    frame_log.add(frame_at(each));
  const EndedFrameLog ended = frame_log.end().get();
  CHECK(ended.recorded + ended.lost == static_cast<std::uint64_t>(added));
  CHECK(ended.recorded >= FrameRing::kRoom);
  if (ended.lost > 0) CHECK(ended.trouble == "the disk was slower than the print");
  const FrameFile file = read_frame_file(path);
  CHECK(file.lost == ended.lost);
  CHECK(file.records.size() == ended.recorded);
}

TEST_CASE("A disk that cannot be written loses the frames, and says why") {
  testing::TemporaryFolder folder;
  EventLoop loop;
  FrameLog frame_log(loop, folder.path() / "missing" / "print-frames");
  for (std::int64_t each = 0; each < 600; ++each)
    frame_log.add(frame_at(each));
  const EndedFrameLog ended = frame_log.end().get();
  CHECK(ended.file.empty());
  CHECK(ended.recorded == 0);
  CHECK(ended.lost == 600);
  CHECK(ended.trouble.find("cannot make ") != std::string::npos);
  CHECK(ended.trouble.find("No such file or directory") != std::string::npos);
}

TEST_CASE("A ring passes all frames on in their order, or says that it has no room") {
  auto ring = std::make_unique<FrameRing>();
  for (std::int64_t each = 0; each < std::int64_t{FrameRing::kRoom}; ++each)
    REQUIRE(ring->add(frame_at(each)));
  CHECK_FALSE(ring->add(frame_at(-1)));
  std::array<FrameRecord, 10> taken;
  CHECK(ring->take(taken) == 10);
  CHECK(taken[9].cut == frame_at(9).cut);
  CHECK(ring->add(frame_at(-1)));
  // Another thread takes what this one adds.
  std::int64_t next = 10;
  bool ordered = true;
  constexpr std::int64_t kAll = 100'000;
  std::jthread taker([&] {
    std::array<FrameRecord, 64> some;
    while (next < kAll) {
      const std::size_t number = ring->take(some);
      for (std::size_t each = 0; each < number; ++each) {
        if (some[each].cut == frame_at(-1).cut) continue;
        ordered = ordered && some[each].cut == frame_at(next).cut;
        ++next;
      }
    }
  });
  for (std::int64_t each = std::int64_t{FrameRing::kRoom}; each < kAll;)
    each += ring->add(frame_at(each)) ? 1 : 0;
  taker.join();
  CHECK(ordered);
  CHECK(ring->size() == 0);
}
