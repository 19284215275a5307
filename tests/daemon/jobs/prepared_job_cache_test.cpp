#include "daemon/jobs/prepared_job_cache.hpp"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/jobs/job_reader.hpp"
#include "daemon/spool/copied_originals.hpp"
#include "daemon/system/memory_room.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

using namespace contourd;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

// What came of a job whose turn came; all of it empty when it was refused.
struct Turn {
  bool prepared_before = false;
  std::string plan_name;
  double height_mm = 0;
};

// A reader that checks a waiting job, and prepares it when its turn comes; in between, a test changes
// something.
class Desk : public testing::PrinterFixture {
 public:
  Desk() {
    fs::copy(config.resins_folder, resins, fs::copy_options::recursive);
    config.resins_folder = resins;
  }

  void put_plate(const std::string& name) const {
    const fs::path plate = spool.folder(Spool::Folder::Incoming) / name;
    fs::create_directory(plate);
    for (const std::string file : {"a.stl", "b.stl", "unused.stl"})
      models::write_binary_stl(plate / file, models::box({0, 0, 0}, {3, 2, 0.2F}));
    put_text(Spool::Folder::Incoming, name + "/plate.json",
             R"({"models": [{"file": "a.stl"}, {"file": "b.stl"}]})");
  }
  // Rewritten by the same number of bytes, as a later write would leave it.
  void rewrite(const std::string& file, float height) const {
    const fs::path path = spool.folder(Spool::Folder::Incoming) / file;
    const auto before = fs::last_write_time(path);
    models::write_binary_stl(path, models::box({0, 0, 0}, {3, 2, height}));
    fs::last_write_time(path, before + 20ms);
  }
  [[nodiscard]] JobFiles incoming(const std::string& file) const {
    return spool.files_of(Spool::Folder::Incoming, file);
  }

  // Checks `file`, changes something, checks another job behind it to its end where one is named, claims
  // `file` as the scheduler does, and prepares it.
  struct Behind {
    std::string file;
    JobReader::Keep keep;
  };
  Turn take_turn(
      const std::string& file, const std::function<void()>& change = [] {},
      const std::optional<Behind>& behind = std::nullopt) {
    std::optional<Turn> turn;
    const auto claim = [&] {
      const JobSettings settings = read_settings(incoming(file), config);
      reader.read(spool.begin(file), settings, [&](ReadJob read) {
        const auto* const job = std::get_if<PreparedJob>(&read);
        turn = job != nullptr ? Turn{job->summary.prepared_before, job->plan.job, job->summary.height_mm}
                              : Turn{};
      });
    };
    reader.check(file, JobReader::Keep::Prepared, [&](const CheckedJob& found) {
      CHECK(std::holds_alternative<JobOutlook>(found));
      change();
      if (!behind) return claim();
      reader.check(behind->file, behind->keep, [&](const CheckedJob&) { claim(); });
    });
    CHECK(run_until([&] { return turn.has_value(); }));
    return turn.value_or(Turn{});
  }

  const fs::path resins = folder.path() / "resins";
  JobReader reader{config, spool, loop};
};

void replace_in(const fs::path& file, std::string_view from, std::string_view to) {
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  text.replace(at, from.size(), to);
  std::ofstream(file, std::ios::trunc) << text;
}

}  // namespace

TEST_CASE("A job that was prepared for its check is not prepared again when nothing has changed") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put_text(Spool::Folder::Incoming, "part.json", R"({"scale": 2})");
  const Turn turn = desk.take_turn("part.stl");
  CHECK(turn.prepared_before);
  CHECK(turn.plan_name == "part");
  CHECK(turn.height_mm == contourd::testing::Approx(0.4));
}

TEST_CASE("A plate that was prepared for its check is not either, whatever else comes into its folder") {
  Desk desk;
  desk.put_plate("plate");
  CHECK(desk.take_turn("plate",
                       [&] {
                         desk.rewrite("plate/unused.stl", 5);
                         desk.put_text(Spool::Folder::Incoming, "plate/note.txt", "for myself");
                       })
            .prepared_before);
}

TEST_CASE("A job that was prepared for its check is printed under the name that it has in printing") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put(Spool::Folder::Done, "part.stl");
  const Turn turn = desk.take_turn("part.stl");
  CHECK(turn.prepared_before);
  CHECK(turn.plan_name != "part");
}

TEST_CASE("A job whose model was replaced is prepared again") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  const Turn turn = desk.take_turn("part.stl", [&] {
    const fs::path other = desk.folder.path() / "other.stl";
    models::write_binary_stl(other, models::box({0, 0, 0}, {3, 2, 0.6F}));
    fs::rename(other, desk.incoming("part.stl").model);
  });
  CHECK_FALSE(turn.prepared_before);
  CHECK(turn.height_mm == contourd::testing::Approx(0.6));
}

TEST_CASE("A job whose model was written anew in its place is prepared again") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  const Turn turn = desk.take_turn("part.stl", [&] { desk.rewrite("part.stl", 0.6F); });
  CHECK_FALSE(turn.prepared_before);
  CHECK(turn.height_mm == contourd::testing::Approx(0.6));
}

TEST_CASE("A job whose ticket was edited is prepared again") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put_text(Spool::Folder::Incoming, "part.json", R"({"scale": 2})");
  const Turn turn = desk.take_turn(
      "part.stl", [&] { desk.put_text(Spool::Folder::Incoming, "part.json", R"({"scale": 3})"); });
  CHECK_FALSE(turn.prepared_before);
  CHECK(turn.height_mm == contourd::testing::Approx(0.6));
}

TEST_CASE("A job that got a ticket, or lost it, is prepared again") {
  for (const bool had_one : {false, true}) {
    Desk desk;
    desk.put(Spool::Folder::Incoming, "part.stl");
    const fs::path ticket = desk.spool.folder(Spool::Folder::Incoming) / "part.json";
    if (had_one) desk.put_text(Spool::Folder::Incoming, "part.json", R"({"scale": 2})");
    const Turn turn = desk.take_turn("part.stl", [&] {
      if (had_one)
        fs::remove(ticket);
      else
        desk.put_text(Spool::Folder::Incoming, "part.json", R"({"scale": 2})");
    });
    CHECK_FALSE(turn.prepared_before);
    CHECK(turn.height_mm == contourd::testing::Approx(had_one ? 0.2 : 0.4));
  }
}

TEST_CASE("A job whose resin's profile was edited is prepared again") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  CHECK_FALSE(desk.take_turn("part.stl",
                             [&] {
                               const fs::path profile = desk.resins / (desk.config.resin + ".json");
                               replace_in(profile, "\"bottom_layers\": ", "\"bottom_layers\": 1");
                             })
                  .prepared_before);
}

TEST_CASE("A job is prepared again for a printer that has another resin") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  CHECK_FALSE(desk.take_turn("part.stl",
                             [&] {
                               fs::copy(desk.resins / (desk.config.resin + ".json"),
                                        desk.resins / "other.json");
                               desk.config.resin = "other";
                             })
                  .prepared_before);
}

TEST_CASE("A plate is prepared again when one of its models or its ticket has changed") {
  const auto changed = [](const std::function<void(const Desk&)>& change) {
    Desk desk;
    desk.put_plate("plate");
    return !desk.take_turn("plate", [&] { change(desk); }).prepared_before;
  };
  CHECK(changed([](const Desk& desk) { desk.rewrite("plate/b.stl", 0.6F); }));
  CHECK(changed([](const Desk& desk) {
    desk.put_text(Spool::Folder::Incoming, "plate/plate.json",
                  R"({"models": [{"file": "a.stl"}, {"file": "b.stl", "scale": 2}]})");
  }));
  CHECK(changed([](const Desk& desk) {
    desk.put_text(Spool::Folder::Incoming, "plate/plate.json", R"({"models": [{"file": "a.stl"}]})");
  }));
  CHECK(changed([](const Desk& desk) {
    // Another folder of the same name and content.
    const fs::path plate = desk.incoming("plate").model, aside = desk.folder.path() / "aside";
    fs::rename(plate, aside);
    fs::copy(aside, plate);
  }));
}

TEST_CASE("A job that is forgotten is prepared again") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  CHECK_FALSE(desk.take_turn("part.stl", [&] { desk.reader.forget("part.stl"); }).prepared_before);
}

TEST_CASE("What is kept of one job stays when another is forgotten or checked behind it") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put(Spool::Folder::Incoming, "other.stl");
  CHECK(desk.take_turn(
                "part.stl", [&] { desk.reader.forget("other.stl"); },
                Desk::Behind{"other.stl", JobReader::Keep::Nothing})
            .prepared_before);
}

TEST_CASE("Only the last of several checked jobs is kept") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put(Spool::Folder::Incoming, "other.stl");
  CHECK_FALSE(desk.take_turn(
                      "part.stl", [] {}, Desk::Behind{"other.stl", JobReader::Keep::Prepared})
                  .prepared_before);
}

TEST_CASE("What is kept gives way when a check needs its memory") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  desk.put(Spool::Folder::Incoming, "other.stl");
  // The other would find room in a process that held nothing else.
  const std::vector<char> held(200'000'000, 1);
  CHECK_FALSE(desk.take_turn(
                      "part.stl",
                      [&] {
                        constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
                        desk.config.memory_limit_bytes = memory_room(kMost).held + 1'000'000;
                      },
                      Desk::Behind{"other.stl", JobReader::Keep::Nothing})
                  .prepared_before);
  CHECK(held.back() == 1);
}

TEST_CASE("A model behind a symbolic link is not kept, as a change of it would not show") {
  Desk desk;
  desk.put_plate("plate");
  const fs::path model = desk.incoming("plate").model / "b.stl", elsewhere = desk.folder.path() / "b.stl";
  fs::rename(model, elsewhere);
  fs::create_symlink(elsewhere, model);
  const JobFiles files = desk.incoming("plate");
  PreparedJobCache kept;
  kept.keep(files, mark_of(files), PreparedJob{});
  CHECK(kept.empty());
}

TEST_CASE("A job whose files change while they are read is not kept") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  const JobFiles files = desk.incoming("part.stl");
  const std::string mark = mark_of(files);
  PreparedJobCache kept;
  kept.keep(files, mark, PreparedJob{});
  CHECK_FALSE(kept.empty());
  desk.rewrite("part.stl", 0.6F);
  kept.keep(files, mark, PreparedJob{});
  CHECK(kept.empty());
}

TEST_CASE("A job without settings, as its ticket is a reason to refuse it, is prepared to hear why") {
  Desk desk;
  desk.put(Spool::Folder::Incoming, "part.stl");
  const JobFiles files = desk.incoming("part.stl");
  PreparedJobCache kept;
  kept.keep(files, mark_of(files), PreparedJob{});
  CHECK_FALSE(kept.take(files, std::nullopt));
  CHECK(kept.empty());
}
