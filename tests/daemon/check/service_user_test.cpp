#include "daemon/check/service_user.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
namespace fs = std::filesystem;

namespace {

const SystemUser kNobody{"nobody", 65534, 65534};

// Where the unit hides nothing, and nobody can go.
class Place {
 public:
  Place() : path_("/opt/contourd-test-" + std::to_string(::getpid())) {
    fs::create_directories(path_ / "resins");
    fs::create_directories(path_ / "spool");
    fs::permissions(path_ / "spool", fs::perms::all);
    printer.files = {file("contourd.json"), file("resins/standard.json")};
    printer.resins_folder = path_ / "resins";
    printer.spool_folder = path_ / "spool";
    printer.control_socket = "/run/contourd/control.sock";
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  ~Place() {
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

bool skipped() {
  if (::geteuid() == 0) return false;
  std::puts("SKIPPED: only root can be another user");
  return true;
}

using Files = std::vector<std::string>;

}  // namespace

TEST_CASE("What everybody can read is within the service's reach") {
  if (skipped()) return;
  CHECK(Place().out_of_reach().empty());
}

TEST_CASE("Files and folders that root alone can read are out of the service's reach, each told") {
  if (skipped()) return;
  const Place place;
  place.hide("contourd.json");
  CHECK(place.out_of_reach() == Files{place.path("contourd.json")});
  place.hide("resins");
  CHECK(place.out_of_reach() ==
        Files{place.path("contourd.json"), place.path("resins/standard.json"), place.path("resins")});
}

TEST_CASE("A spool that the service cannot write is told, and so is one that it cannot make") {
  if (skipped()) return;
  Place place;
  fs::create_directories(place.path("spool/incoming"));  // root's
  CHECK(place.out_of_reach() == Files{place.path("spool/incoming")});
  fs::permissions(place.path("spool"),
                  fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
  CHECK(place.out_of_reach() == Files{place.path("spool"), place.path("spool/incoming")});
  place.printer.spool_folder = place.path("new/spool");
  CHECK(place.out_of_reach() == Files{place.path("resins").parent_path()});
}

TEST_CASE("A socket's folder that the service cannot write is told, but for one that is made for it") {
  if (skipped()) return;
  Place place;
  place.printer.control_socket = place.path("resins/control.sock");
  CHECK(place.out_of_reach() == Files{place.path("resins")});
}

TEST_CASE("What the unit hides from the service is out of its reach, whatever the permissions") {
  if (skipped()) return;
  const testing::TemporaryFolder temporary;
  fs::permissions(temporary.path(), fs::perms::all);
  Place place;
  place.printer.files.push_back(temporary.write("lamp.png", "lamp"));
  CHECK(place.out_of_reach() == Files{temporary.path() / "lamp.png"});
}
