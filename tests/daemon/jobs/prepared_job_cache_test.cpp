#include "daemon/jobs/prepared_job_cache.hpp"

#include <filesystem>
#include <fstream>

#include "daemon/jobs/job_reader.hpp"
#include "daemon/spool/copied_originals.hpp"
#include "daemon/system/memory_room.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace fs = std::filesystem;

namespace {

// The result of reading a job whose turn has come; empty if it was refused.
struct Turn {
  bool prepared_before = false;
  std::string plan_name;
  double height_mm = 0;
};

// A reader that checks a waiting job, and reads it when its turn comes; a test changes something in between.
class CachedJobFixture : public testing::PrinterFixture {
 public:
  CachedJobFixture() {
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
  [[nodiscard]] fs::path ticket() const { return spool.folder(Spool::Folder::Incoming) / "part.json"; }
  void put_ticket(const std::string& text) const { put_text(Spool::Folder::Incoming, "part.json", text); }
  // Rewrites a model with the same number of bytes and a later time.
  void rewrite(const std::string& file, float height) const {
    const fs::path path = spool.folder(Spool::Folder::Incoming) / file;
    const auto before = fs::last_write_time(path);
    models::write_binary_stl(path, models::box({0, 0, 0}, {3, 2, height}));
    fs::last_write_time(path, before + 20ms);
  }
  [[nodiscard]] JobFiles incoming(const std::string& file) const {
    return spool.files_of(Spool::Folder::Incoming, file);
  }

  struct OtherCheck {
    std::string file;
    JobReader::Keep keep;
  };
  // Checks `file`, changes something, checks another job to its end if one is given, claims `file` as the
  // scheduler does, and reads it.
  Turn take_turn(
      const std::string& file, const std::function<void()>& change = [] {},
      const std::optional<OtherCheck>& other = std::nullopt) {
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
      if (!other) return claim();
      reader.check(other->file, other->keep, [&](const CheckedJob&) { claim(); });
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

TEST_CASE_METHOD(CachedJobFixture,
                 "A job that its check has prepared is not prepared again if nothing has changed") {
  put(Spool::Folder::Incoming, "part.stl");
  put_ticket(R"({"scale": 2})");
  const Turn turn = take_turn("part.stl");
  CHECK(turn.prepared_before);
  CHECK(turn.plan_name == "part");
  CHECK(turn.height_mm == contourd::testing::Approx(0.4));
}

TEST_CASE_METHOD(
    CachedJobFixture,
    "A plate that its check has prepared is not prepared again because of other files in its folder") {
  put_plate("plate");
  CHECK(take_turn("plate", [&] {
          rewrite("plate/unused.stl", 5);
          put_text(Spool::Folder::Incoming, "plate/note.txt", "for myself");
        }).prepared_before);
}

TEST_CASE_METHOD(CachedJobFixture,
                 "A job that its check has prepared is printed under its name in printing/") {
  put(Spool::Folder::Incoming, "part.stl");
  put(Spool::Folder::Done, "part.stl");
  const Turn turn = take_turn("part.stl");
  CHECK(turn.prepared_before);
  CHECK(turn.plan_name != "part");
}

TEST_CASE(
    "A job is prepared again if its model, its ticket or its profile has changed, or if it is forgotten") {
  const std::string twice = R"({"scale": 2})";
  struct Row {
    const char* what;
    std::string ticket;
    std::function<void(CachedJobFixture&)> change;
    double height_mm;
  };
  for (const Row& row : {
           Row{"the model was replaced", "",
               [](CachedJobFixture& f) {
                 const fs::path other = f.folder.path() / "other.stl";
                 models::write_binary_stl(other, models::box({0, 0, 0}, {3, 2, 0.6F}));
                 fs::rename(other, f.incoming("part.stl").model);
               },
               0.6},
           Row{"the model was rewritten in place", "",
               [](CachedJobFixture& f) { f.rewrite("part.stl", 0.6F); }, 0.6},
           Row{"the ticket was edited", twice, [](CachedJobFixture& f) { f.put_ticket(R"({"scale": 3})"); },
               0.6},
           Row{"there is a ticket now", "", [&](CachedJobFixture& f) { f.put_ticket(twice); }, 0.4},
           Row{"the ticket was removed", twice, [](CachedJobFixture& f) { fs::remove(f.ticket()); }, 0.2},
           Row{"the profile was edited", "",
               [](CachedJobFixture& f) {
                 replace_in(f.resins / (f.config.resin + ".json"),
                            "\"bottom_layers\": ", "\"bottom_layers\": 1");
               },
               0.2},
           Row{"the printer has another resin", "",
               [](CachedJobFixture& f) {
                 fs::copy(f.resins / (f.config.resin + ".json"), f.resins / "other.json");
                 f.config.resin = "other";
               },
               0.2},
           Row{"the job was forgotten", "", [](CachedJobFixture& f) { f.reader.forget("part.stl"); }, 0.2},
       }) {
    CAPTURE(row.what);
    CachedJobFixture fixture;
    fixture.put(Spool::Folder::Incoming, "part.stl");
    if (!row.ticket.empty()) fixture.put_ticket(row.ticket);
    const Turn turn = fixture.take_turn("part.stl", [&] { row.change(fixture); });
    CHECK_FALSE(turn.prepared_before);
    CHECK(turn.height_mm == contourd::testing::Approx(row.height_mm));
  }
}

TEST_CASE("A plate is prepared again if one of its models or its ticket has changed") {
  const auto changed = [](const std::function<void(const CachedJobFixture&)>& change) {
    CachedJobFixture fixture;
    fixture.put_plate("plate");
    return !fixture.take_turn("plate", [&] { change(fixture); }).prepared_before;
  };
  CHECK(changed([](const CachedJobFixture& fixture) { fixture.rewrite("plate/b.stl", 0.6F); }));
  CHECK(changed([](const CachedJobFixture& fixture) {
    fixture.put_text(Spool::Folder::Incoming, "plate/plate.json",
                     R"({"models": [{"file": "a.stl"}, {"file": "b.stl", "scale": 2}]})");
  }));
  CHECK(changed([](const CachedJobFixture& fixture) {
    fixture.put_text(Spool::Folder::Incoming, "plate/plate.json", R"({"models": [{"file": "a.stl"}]})");
  }));
  CHECK(changed([](const CachedJobFixture& fixture) {
    // Another folder of the same name and content.
    const fs::path plate = fixture.incoming("plate").model, aside = fixture.folder.path() / "aside";
    fs::rename(plate, aside);
    fs::copy(aside, plate);
  }));
}

TEST_CASE_METHOD(CachedJobFixture,
                 "A job stays in the cache when another job is forgotten, or checked after it") {
  put(Spool::Folder::Incoming, "part.stl");
  put(Spool::Folder::Incoming, "other.stl");
  CHECK(take_turn(
            "part.stl", [&] { reader.forget("other.stl"); },
            CachedJobFixture::OtherCheck{"other.stl", JobReader::Keep::Nothing})
            .prepared_before);
}

TEST_CASE_METHOD(CachedJobFixture, "Only the last of several checked jobs is cached") {
  put(Spool::Folder::Incoming, "part.stl");
  put(Spool::Folder::Incoming, "other.stl");
  CHECK_FALSE(take_turn(
                  "part.stl", [] {}, CachedJobFixture::OtherCheck{"other.stl", JobReader::Keep::Prepared})
                  .prepared_before);
}

TEST_CASE_METHOD(CachedJobFixture, "The cached job is dropped when a check needs its memory") {
  put(Spool::Folder::Incoming, "part.stl");
  put(Spool::Folder::Incoming, "other.stl");
  // The check of the other job would have enough memory in a process that held nothing else.
  const std::vector<char> held(200'000'000, 1);
  CHECK_FALSE(take_turn(
                  "part.stl",
                  [&] {
                    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
                    config.memory_limit_bytes = memory_room(kMost).held + 1'000'000;
                  },
                  CachedJobFixture::OtherCheck{"other.stl", JobReader::Keep::Nothing})
                  .prepared_before);
  CHECK(held.back() == 1);
}

TEST_CASE_METHOD(CachedJobFixture,
                 "A model behind a symbolic link is not cached, because its changes would go unnoticed") {
  put_plate("plate");
  const fs::path model = incoming("plate").model / "b.stl", elsewhere = folder.path() / "b.stl";
  fs::rename(model, elsewhere);
  fs::create_symlink(elsewhere, model);
  const JobFiles files = incoming("plate");
  PreparedJobCache cache;
  cache.keep(files, mark_of(files), PreparedJob{});
  CHECK(cache.empty());
}

TEST_CASE_METHOD(CachedJobFixture, "A job whose files change while they are read is not cached") {
  put(Spool::Folder::Incoming, "part.stl");
  const JobFiles files = incoming("part.stl");
  const std::string mark = mark_of(files);
  PreparedJobCache cache;
  cache.keep(files, mark, PreparedJob{});
  CHECK_FALSE(cache.empty());
  rewrite("part.stl", 0.6F);
  cache.keep(files, mark, PreparedJob{});
  CHECK(cache.empty());
}

TEST_CASE_METHOD(CachedJobFixture,
                 "A job without settings is not taken from the cache, because its ticket is invalid") {
  put(Spool::Folder::Incoming, "part.stl");
  const JobFiles files = incoming("part.stl");
  PreparedJobCache cache;
  cache.keep(files, mark_of(files), PreparedJob{});
  CHECK_FALSE(cache.take(files, std::nullopt));
  CHECK(cache.empty());
}
