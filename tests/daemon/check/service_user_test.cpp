#include "daemon/check/config_check.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace fs = std::filesystem;

namespace {

const SystemUser kNobody{"nobody", 65534, 65534};

// A printer's files in a folder that the unit does not hide and that the user nobody can enter.
class ServiceFilesFixture {
 public:
  ServiceFilesFixture() : path_("/opt/contourd-test-" + std::to_string(::getpid())) {
    fs::create_directories(path_ / "resins");
    fs::create_directories(path_ / "spool");
    fs::permissions(path_ / "spool", fs::perms::all);
    printer.files = {file("contourd.json"), file("resins/standard.json")};
    printer.resins_folder = path_ / "resins";
    printer.spool_folder = path_ / "spool";
    printer.control_socket = "/run/contourd/control.sock";
  }
  ServiceFilesFixture(const ServiceFilesFixture&) = delete;
  ServiceFilesFixture& operator=(const ServiceFilesFixture&) = delete;
  ~ServiceFilesFixture() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  [[nodiscard]] fs::path path(const std::string& name) const { return path_ / name; }
  void hide(const std::string& name) const { fs::permissions(path_ / name, fs::perms::owner_all); }
  [[nodiscard]] std::vector<std::string> out_of_reach() const {
    std::vector<std::string> files;
    for (const Violation& each : contourd::out_of_reach(kNobody, printer))
      files.push_back(each.file);
    CHECK(::geteuid() == 0);
    return files;
  }

  PrinterConfig printer;

 private:
  [[nodiscard]] fs::path file(const std::string& name) const {
    std::FILE* const made = std::fopen((path_ / name).c_str(), "w");
    REQUIRE(made != nullptr);
    std::fclose(made);
    fs::permissions(path_ / name, fs::perms::owner_all | fs::perms::group_read | fs::perms::others_read);
    return path_ / name;
  }

  fs::path path_;
};

bool skipped_without_root() {
  if (::geteuid() == 0) return false;
  std::puts("SKIPPED: only root can take on another user's rights");
  return true;
}

using Files = std::vector<std::string>;

}  // namespace

TEST_CASE("Files that everyone can read are accessible to the service") {
  if (skipped_without_root()) return;
  CHECK(ServiceFilesFixture().out_of_reach().empty());
}

TEST_CASE("Each file and folder that only root can read is reported as inaccessible") {
  if (skipped_without_root()) return;
  const ServiceFilesFixture fixture;
  fixture.hide("contourd.json");
  CHECK(fixture.out_of_reach() == Files{fixture.path("contourd.json")});
  fixture.hide("resins");
  CHECK(fixture.out_of_reach() ==
        Files{fixture.path("contourd.json"), fixture.path("resins/standard.json"), fixture.path("resins")});
}

TEST_CASE("A spool that the service cannot write or create is reported") {
  if (skipped_without_root()) return;
  ServiceFilesFixture fixture;
  fs::create_directories(fixture.path("spool/incoming"));  // root's
  CHECK(fixture.out_of_reach() == Files{fixture.path("spool/incoming")});
  fs::permissions(fixture.path("spool"),
                  fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
  CHECK(fixture.out_of_reach() == Files{fixture.path("spool"), fixture.path("spool/incoming")});
  fixture.printer.spool_folder = fixture.path("new/spool");
  CHECK(fixture.out_of_reach() == Files{fixture.path("resins").parent_path()});
}

TEST_CASE("A socket's folder that the service cannot write is reported unless systemd creates it") {
  if (skipped_without_root()) return;
  ServiceFilesFixture fixture;
  fixture.printer.control_socket = fixture.path("resins/control.sock");
  CHECK(fixture.out_of_reach() == Files{fixture.path("resins")});
}

TEST_CASE("Files that the unit hides are reported as inaccessible, whatever their permissions") {
  if (skipped_without_root()) return;
  const testing::TemporaryFolder temporary;
  fs::permissions(temporary.path(), fs::perms::all);
  ServiceFilesFixture fixture;
  fixture.printer.files.push_back(temporary.write("lamp.png", "lamp"));
  CHECK(fixture.out_of_reach() == Files{temporary.path() / "lamp.png"});
}
