#include "daemon/frames/frame_file.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/frames/frame_summary.hpp"
#include "daemon/system/checksum.hpp"
#include "daemon/system/regular_file.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace {

using namespace std::chrono_literals;

FrameRecord frame_number(std::int64_t number) {
  return {.cut = Nanometers{300'000 + 2'000 * number},
          .first = Nanometers{300'010 + 2'000 * number},
          .last = Nanometers{301'500 + 2'000 * number},
          .shown = TimePoint(1h + 16'666'667ns * number),
          .lit = 16'666us,
          .refreshes = 1,
          .missed = static_cast<std::uint32_t>(number % 3),
          .layer = static_cast<std::int32_t>(number / 25),
          .begins = number == 0};
}

std::vector<FrameRecord> frames_up_to(std::int64_t number) {
  std::vector<FrameRecord> frames;
  for (std::int64_t each = 0; each < number; ++each)
    frames.push_back(frame_number(each));
  return frames;
}

class FrameFileFixture {
 public:
  // Writes these frames in blocks, and the end unless `lost` is negative.
  void write(const std::vector<FrameRecord>& frames, std::int64_t lost = 0) const {
    FrameFileWriter writer(path);
    for (std::size_t from = 0; from < frames.size(); from += FrameFile::kBlockRecords)
      writer.add(std::span(frames).subspan(from, std::min(frames.size() - from, FrameFile::kBlockRecords)));
    if (lost >= 0) writer.finish(static_cast<std::uint64_t>(lost));
  }
  [[nodiscard]] std::string bytes() const { return frame_file_text(path); }
  [[nodiscard]] bool is_refused() const {
    try {
      (void)read_frame_file(path);
      return false;
    } catch (const std::runtime_error&) {
      return true;
    }
  }
  void put(std::string_view bytes) const { std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes; }

  testing::TemporaryFolder folder;
  std::filesystem::path path = folder.path() / "part.frames.bin";
};

}  // namespace

TEST_CASE_METHOD(FrameFileFixture, "Frames are read as they were written, in the size that is documented") {
  for (const std::int64_t number : {0, 1, 512, 513, 1'500}) {
    CAPTURE(number);
    const std::vector<FrameRecord> frames = frames_up_to(number);
    write(frames, 7);
    const FrameFile file = read_frame_file(path);
    CHECK(file.records == frames);
    CHECK(file.lost == 7);
    CHECK(file.complete);
    CHECK(static_cast<std::int64_t>(bytes().size()) == 32 + number * 32 + (number + 511) / 512 * 16 + 32);
  }
}

TEST_CASE_METHOD(FrameFileFixture, "The bytes of a record are those of the documentation") {
  FrameRecord frame = frame_number(2);
  frame.cut = Nanometers{0x01020304};
  frame.last = Nanometers{-2};
  frame.layer = 0x0506;
  frame.begins = true;
  frame.light = 254;
  frame.refreshes = 70'000;  // more than can be told
  write({frame});
  const std::string record = bytes().substr(32 + 16, 32);
  CHECK(bytes().starts_with("contourd-frames\n"));
  CHECK(record.substr(8, 4) == "\x04\x03\x02\x01");
  CHECK(record.substr(16, 4) == "\xfe\xff\xff\xff");
  CHECK(record.substr(24, 4) == std::string("\x06\x05\x80\x80", 4));
  CHECK(record.substr(28, 4) == std::string("\xff\xff\x02\x00", 4));
  CHECK(read_frame_file(path).records.front().refreshes == 65'535);
  CHECK(read_frame_file(path).records.front().layer == 0x0506);
  CHECK(read_frame_file(path).records.front().light == 254);
}

TEST_CASE_METHOD(FrameFileFixture,
                 "A file that a power cut ended has its whole blocks, and is not complete") {
  const std::vector<FrameRecord> frames = frames_up_to(1'200);
  write(frames, -1);
  CHECK(read_frame_file(path).records == frames);
  CHECK_FALSE(read_frame_file(path).complete);
  put(bytes().substr(0, 32 + 2 * (16 + 512 * 32) + 100));
  const FrameFile torn = read_frame_file(path);
  CHECK(torn.records == frames_up_to(1'024));
  CHECK_FALSE(torn.complete);
}

TEST_CASE_METHOD(FrameFileFixture, "A byte that is changed anywhere is noticed") {
  write(frames_up_to(600));
  const std::string whole = bytes();
  std::mt19937 random(3);
  for (int attempt = 0; attempt < 300; ++attempt) {
    const std::size_t at = attempt < 96 ? static_cast<std::size_t>(attempt) : random() % whole.size();
    CAPTURE(at);
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ (1 << random() % 8));
    put(changed);
    CHECK(is_refused() == (at < FrameFile::kHeaderBytes));
    if (at >= FrameFile::kHeaderBytes) CHECK_FALSE(read_frame_file(path).complete);
  }
  put(whole + "xy");
  CHECK_FALSE(read_frame_file(path).complete);
  CHECK(read_frame_file(path).after_end == 2);
}

TEST_CASE_METHOD(FrameFileFixture, "A file that is no record of frames is refused with the reason") {
  const auto refusal = [this] {
    try {
      (void)read_frame_file(path);
      return std::string();
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
  };
  CHECK_THROWS_AS(read_frame_file(path), UnreadableFile);  // there is none
  put("solid cube");
  CHECK(refusal() == "it is no record of frames");
  write(frames_up_to(3));
  std::string other = bytes();
  other[16] = 2;
  put(other);
  CHECK(refusal() == "it is a record of frames of version 2, and only version 1 can be read");
  std::filesystem::resize_file(path, 17'000'000);
  CHECK(refusal() == "it has more than 16793664 bytes, and no record of frames has");
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  CHECK_THROWS_AS(FrameFileWriter(path), std::system_error);
}

TEST_CASE_METHOD(FrameFileFixture, "A block has records, and only the last one has fewer than 512") {
  FrameFileWriter writer(path);
  const auto frames = frames_up_to(513);
  using testing::contract_broken_by;
  constexpr const char* kRule = "the block has its number of records, and the file has room for it";
  CHECK(contract_broken_by([&] { writer.add({}); }) == kRule);
  CHECK(contract_broken_by([&] { writer.add(frames); }) == kRule);
  writer.add(std::span(frames).first(5));
  CHECK(contract_broken_by([&] { writer.add(std::span(frames).first(5)); }) == kRule);
}

TEST_CASE("The summary of frames has their number, light, and the distances of cuts from the plate") {
  CHECK(summary_of({}).masks == 0);
  std::vector<FrameRecord> frames = frames_up_to(10);
  frames[6].begins = true;
  frames[4].first = frames[4].cut - Nanometers{25};
  frames[7].last = frames[7].first + Nanometers{4'100};
  frames[8].cut = frames[8].first - Nanometers{73'000};
  const FrameSummary summary = summary_of(frames);
  CHECK(summary.masks == 10);
  CHECK(summary.rises == 2);
  CHECK(summary.refreshes == 10);
  CHECK(summary.missed == 9);
  CHECK(summary.lit == 166'660us);
  CHECK(summary.lowest == Nanometers{300'010});
  CHECK(summary.highest == Nanometers{319'500});
  CHECK(summary.nearest.way == Nanometers{-25});
  CHECK(summary.nearest.at == frames[4].first);
  CHECK(summary.farthest.way == Nanometers{73'000});
  CHECK(summary.farthest.at == frames[8].first);
  CHECK(summary.longest.way == Nanometers{4'100});
  CHECK(summary.longest.at == frames[7].last);
}
