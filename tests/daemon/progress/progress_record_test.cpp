#include "daemon/progress/progress_record.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "daemon/progress/interrupted_print.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/system/file_contents.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace fs = std::filesystem;

namespace {

JobProgress progress_in_layer(std::int32_t layer, PrintPhase phase) {
  const Nanometers thickness{50'000}, bottom{layer * thickness.count()};
  return {.job = "gear",
          .layers = 200,
          .marks = {"0123456789abcdef", 42},
          .lit = layer * 2s,
          .written = std::chrono::system_clock::time_point(1'700'000'000'123ms),
          .print = {phase, layer, bottom, thickness, 2'500ms, 1'200ms, phase == PrintPhase::Lit,
                    PrintProgress::Heights{bottom + thickness, bottom + thickness}},
          .changes = {{110, 6.5, 2, 3, 0.1}, {0, 3}, true}};
}

void overwrite(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

class RecordFixture {
 public:
  testing::TemporaryFolder folder;
  fs::path file = folder.path() / "print-progress";
  ProgressRecord record{file};
};

}  // namespace

TEST_CASE("The progress of a print is read as it was written, and the latest copy counts") {
  RecordFixture fixture;
  CHECK_FALSE(fixture.record.read().progress);
  CHECK(fixture.record.read().trouble.empty());
  fixture.record.begin(progress_in_layer(0, PrintPhase::Starting));
  CHECK(fixture.record.read().progress == progress_in_layer(0, PrintPhase::Starting));
  const std::uintmax_t size = fs::file_size(fixture.file);
  for (std::int32_t layer = 1; layer < 6; ++layer) {
    const JobProgress progress = progress_in_layer(layer, PrintPhase::Lit);
    fixture.record.write(progress);
    CHECK(fixture.record.read().progress == progress);
  }
  CHECK(fs::file_size(fixture.file) == size);
  JobProgress many = progress_in_layer(6, PrintPhase::Lit);
  many.changes.excluded.assign(ProgressRecord::kMostExcluded + 1, 4'000'000'000);
  fixture.record.write(many);
  many.changes.excluded.pop_back();
  many.changes.complete = false;
  CHECK(fixture.record.read().progress == many);
  CHECK(why_not_resumable({.files = {}, .progress = many}, true, false).starts_with("more copies"));
  JobProgress moving = progress_in_layer(7, PrintPhase::Lifting);
  moving.print.plate.reset();
  ProgressRecord next(fixture.file);
  next.go_on();
  next.write(moving);
  CHECK(next.read().progress == moving);
  next.end();
  CHECK_FALSE(fs::exists(fixture.file));
}

TEST_CASE("A power cut during a write leaves the progress before, whatever part of the copy is on the disk") {
  RecordFixture fixture;
  fixture.record.begin(progress_in_layer(0, PrintPhase::Starting));
  for (std::int32_t layer = 1; layer < 4; ++layer) {
    const JobProgress before = *fixture.record.read().progress;
    const JobProgress after = progress_in_layer(layer, PrintPhase::BeforeLight);
    const std::string old_text = testing::contents_of(fixture.file);
    fixture.record.write(after);
    const std::string new_text = testing::contents_of(fixture.file);
    REQUIRE(old_text.size() == new_text.size());
    const std::size_t copy = layer % 2 == 1 ? ProgressRecord::kCopyDistance : 0;
    for (std::size_t cut = 0; cut <= 400; ++cut) {
      for (const bool first_part : {true, false}) {
        std::string torn = first_part ? old_text : new_text;
        const std::string& rest = first_part ? new_text : old_text;
        std::copy_n(rest.begin() + static_cast<std::ptrdiff_t>(copy), cut,
                    torn.begin() + static_cast<std::ptrdiff_t>(copy));
        overwrite(fixture.file, torn);
        const ProgressRecord::Found found = fixture.record.read();
        INFO("cut at byte " << cut << (first_part ? ", the first part is new" : ", the last part is new"));
        REQUIRE(found.progress);
        CHECK((found.progress == before || found.progress == after));
        if (torn == old_text) CHECK(found.progress == before);
        if (torn == new_text) CHECK(found.progress == after);
        if (torn != old_text && torn != new_text) CHECK(found.trouble.ends_with("is damaged"));
      }
    }
    overwrite(fixture.file, new_text);
  }
}

TEST_CASE("A record that is damaged as a whole, or of another version, is reported and not used") {
  RecordFixture fixture;
  fixture.record.begin(progress_in_layer(3, PrintPhase::Lit));
  const std::string text = testing::contents_of(fixture.file);
  // Each changed byte of the only copy makes it invalid; its zero bytes of padding too.
  for (std::size_t at = 0; at < ProgressRecord::kCopyBytes; at += at < 300 ? 1 : 97) {
    std::string damaged = text;
    damaged[at] ^= 1;
    overwrite(fixture.file, damaged);
    INFO("byte " << at);
    CHECK_FALSE(fixture.record.read().progress);
    CHECK_FALSE(fixture.record.read().trouble.empty());
  }
  std::string other = text;
  other[std::string("contourd-progress ").size()] = '2';
  overwrite(fixture.file, other);
  CHECK_FALSE(fixture.record.read().progress);
  CHECK(fixture.record.read().trouble.ends_with("is of another version of contourd"));
  for (const std::string& cut : {text.substr(0, 100), std::string("x"), std::string(70'000, 'x')}) {
    overwrite(fixture.file, cut);
    CHECK_FALSE(fixture.record.read().progress);
    CHECK(fixture.record.read().trouble.ends_with("is damaged"));
  }
}

TEST_CASE("A record that cannot be begun refuses each write") {
  RecordFixture fixture;
  ProgressRecord record(fixture.folder.path() / "missing" / "print-progress");
  CHECK_THROWS_AS(record.begin(progress_in_layer(0, PrintPhase::Starting)), std::system_error);
  CHECK_THROWS_AS(record.write(progress_in_layer(1, PrintPhase::Lit)), std::system_error);
  CHECK_THROWS_AS(record.go_on(), std::system_error);
}

TEST_CASE("A progress is described by its layer, its phase and the plate's height") {
  JobProgress progress = progress_in_layer(11, PrintPhase::BeforeLight);
  CHECK(describe(progress) ==
        "in layer 12 of 200, before, during or just after its light, with the plate at 0.600 mm");
  progress.print.phase = PrintPhase::Lifting;
  progress.print.plate->most = Nanometers{5'600'000};
  CHECK(describe(progress) ==
        "in layer 12 of 200, while the plate rose, with the plate between 0.600 and 5.600 mm");
  move_by_hand(progress.print, Nanometers{-100'000});
  move_by_hand(progress.print, Nanometers{2'000'000});
  CHECK(describe(progress) ==
        "in layer 12 of 200, and moved by hand since, with the plate between 0.500 and 7.600 mm");
  move_by_hand(progress.print, std::nullopt);
  move_by_hand(progress.print, Nanometers{2'000'000});
  CHECK(describe(progress) == "in layer 12 of 200, and moved by hand since");
}

TEST_CASE("A record that is not a file is reported and not used, and reading it does not wait") {
  RecordFixture fixture;
  REQUIRE(::mkfifo(fixture.file.c_str(), 0600) == 0);
  CHECK(fixture.record.read().trouble.ends_with("print-progress cannot be used: it is not a regular file"));
  std::filesystem::remove(fixture.file);
  CHECK(fixture.record.read().trouble.empty());
}
