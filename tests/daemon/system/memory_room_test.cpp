#include "daemon/system/memory_room.hpp"

#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

namespace {

// Files of a simulated kernel: 1,000,000 kB available, 20,000 kB held by this process, no limit of a control
// group.
class Kernel {
 public:
  Kernel() {
    write("proc/meminfo", "MemTotal:        2000000 kB\nMemFree:  5 kB\nMemAvailable:    1000000 kB\n");
    write("proc/self/status",
          "Name:\tcontourd\nVmRSS:\t  30000 kB\nRssAnon:\t   18000 kB\nVmSwap:\t 2000 kB\n");
    write("proc/self/cgroup", "0::/system.slice/contourd.service\n");
  }
  void write(const std::string& file, const std::string& text) { folder_.write(file, text); }
  // Limits a control group of version 2.
  void limit(const std::string& group, const std::string& most, const std::string& used) {
    write("cgroup/" + group + "memory.max", most + "\n");
    write("cgroup/" + group + "memory.current", used + "\n");
  }
  [[nodiscard]] MemoryRoom room(std::optional<std::uint64_t> limit = {}) const {
    return memory_room(limit, {folder_.path() / "proc", folder_.path() / "cgroup"});
  }

 private:
  testing::TemporaryFolder folder_;
};

constexpr std::uint64_t kReserve = 64'000'000;
const std::string kSlice = "system.slice/", kService = kSlice + "contourd.service/";

}  // namespace

TEST_CASE("Without a limit, the room is the machine's available memory minus a reserve") {
  const MemoryRoom room = Kernel().room();
  CHECK(room.bytes == 1'024'000'000 - kReserve);
  CHECK(room.held == 20'480'000);
  CHECK(room.reason == "1024 MB are available on this computer, of which 64 MB stay free");
}

TEST_CASE("A limit is for the whole process, so memory that it already holds counts") {
  const MemoryRoom room = Kernel().room(100'000'000);
  CHECK(room.bytes == 100'000'000 - 20'480'000);
  CHECK(room.reason == "memory_limit_mb is 100, and contourd holds 20 MB");
  CHECK(Kernel().room(10'000'000).bytes == 0);
  CHECK(Kernel().room(10'000'000).held == 10'000'000);
}

TEST_CASE("A control group's limit, hard or soft, minus its use counts if the machine has more available") {
  Kernel kernel;
  kernel.limit(kService, "900000000", "300000000");
  kernel.write("cgroup/" + kService + "memory.high", "max\n");
  CHECK(kernel.room().bytes == 600'000'000 - kReserve);
  CHECK(kernel.room().reason == "600 MB are available in the control group, of which 64 MB stay free");
  // Above the soft limit, the control group is slowed down.
  kernel.write("cgroup/" + kService + "memory.high", "500000000\n");
  CHECK(kernel.room().bytes == 200'000'000 - kReserve);
}

TEST_CASE("File pages held by a control group count as available") {
  Kernel kernel;
  kernel.limit(kService, "900000000", "880000000");
  kernel.write("cgroup/" + kService + "memory.stat",
               "anon 80000000\nfile 800000000\ninactive_anon 1\nactive_anon 2\ninactive_file 500000000\n"
               "active_file 100000000\n");
  CHECK(kernel.room().bytes == 620'000'000 - kReserve);
}

TEST_CASE("The control group with the least room counts, at any level") {
  Kernel kernel;
  kernel.limit(kService, "max", "1");
  kernel.limit(kSlice, "700000000", "400000000");
  CHECK(kernel.room().bytes == 300'000'000 - kReserve);
  // In a container, the root group has a limit too.
  kernel.limit("", "250000000", "50000000");
  CHECK(kernel.room().bytes == 200'000'000 - kReserve);
}

TEST_CASE("Control groups of version 1 are read, and an invisible group is ignored") {
  Kernel kernel;
  kernel.write("proc/self/cgroup", "9:name=systemd:/x\n5:cpu,memory:/printers/one\n0::/\n");
  kernel.write("cgroup/memory/printers/memory.limit_in_bytes", "400000000\n");
  kernel.write("cgroup/memory/printers/memory.usage_in_bytes", "350000000\n");
  kernel.write("cgroup/memory/printers/memory.stat",
               "inactive_file 7\nactive_file 7\ntotal_inactive_file 150000000\ntotal_active_file 0\n");
  kernel.write("cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  kernel.write("cgroup/memory/memory.usage_in_bytes", "900000000\n");
  CHECK(kernel.room().bytes == 200'000'000 - kReserve);
}

TEST_CASE("Use above the limit leaves no room, and unknown figures impose no limit") {
  Kernel kernel;
  kernel.limit("", "100", "200");
  CHECK(kernel.room().bytes == 0);
  kernel.write("cgroup/memory.max", "nonsense\n");
  CHECK(kernel.room().bytes == 1'024'000'000 - kReserve);
  kernel.write("proc/self/cgroup", "");
  kernel.write("proc/meminfo", "");
  CHECK(kernel.room().bytes > 1'000'000'000'000);
}

TEST_CASE("The files of this computer's kernel are understood") {
  const MemoryRoom room = memory_room(std::nullopt);
  CHECK(room.bytes < machine_memory().value());
  CHECK(room.held > 0);
}
