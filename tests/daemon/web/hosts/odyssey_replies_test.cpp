#include "daemon/web/hosts/odyssey_replies.hpp"

#include "tests/catch.hpp"

using namespace contourd::web;

namespace {

using Json = ControlLink::Json;

std::vector<HostJob> some_jobs(int count) {
  std::vector<HostJob> jobs;
  for (int i = 0; i < count; ++i)
    jobs.push_back({.name = std::to_string(i), .file = std::to_string(i) + ".stl"});
  return jobs;
}

}  // namespace

TEST_CASE("A status of Odyssey has decimals where its clients throw on whole numbers") {
  HostStatus status{.printer = "p", .phase = HostPhase::Paused};
  status.job = HostJob{.name = "gear", .file = "gear", .is_printing = true, .layers = 9};
  status.layer = 2;
  status.height_mm = 1;
  const Json reply = odyssey_status(status);
  CHECK(reply["physical_state"].dump() == R"({"z":1.0,"z_microns":1000,"curing":false})");
  CHECK((reply["status"] == "Printing" && reply["paused"] == true && reply["layer"] == 2));
  for (const char* key : {"used_material", "print_time", "layer_height"})
    CHECK(reply["print_data"][key].dump() == "0.0");
  CHECK(reply["print_data"]["layer_count"].dump() == "9");
  CHECK(reply["print_data"]["file_data"]["last_modified"].is_number_integer());
}

TEST_CASE("A layer of null means a cancelled print, so a print that begins has layer 0") {
  HostStatus status{.printer = "p", .phase = HostPhase::Starting};
  CHECK(odyssey_status(status)["layer"].is_null());
  CHECK(odyssey_status(status)["print_data"].is_null());
  status.job = HostJob{.name = "gear", .file = "gear", .is_printing = true};
  CHECK(odyssey_status(status)["layer"] == 0);
  status.job.reset();
  status.layer = 9;
  CHECK(odyssey_status(status)["layer"] == 9);
}

TEST_CASE("Each event is one status with its name") {
  const std::string event = odyssey_event({.printer = "p"});
  CHECK(event.starts_with("event: status\ndata: {\"status\":\"Idle\""));
  CHECK(event.ends_with("}\n\n"));
}

TEST_CASE("The pages of a list are bounded, and name the next one") {
  const auto page = [](std::size_t index, std::size_t size) {
    const Json reply = odyssey_files(some_jobs(5), {index, size});
    return std::pair(reply["files"].size(), reply["next_index"]);
  };
  CHECK(page(0, 100) == std::pair(std::size_t{5}, Json()));
  CHECK(page(0, 2) == std::pair(std::size_t{2}, Json(1)));
  CHECK(page(2, 2) == std::pair(std::size_t{1}, Json()));
  CHECK(page(1, 5) == std::pair(std::size_t{0}, Json()));
  CHECK(page(SIZE_MAX, SIZE_MAX) == std::pair(std::size_t{0}, Json()));
}

TEST_CASE("The greatest height is that of the method move") {
  const Json methods{
      {"methods",
       {{{"name", "stop"}}, {{"name", "move"}, {"parameters", {{{"name", "to_mm"}, {"most", 160}}}}}}}};
  CHECK(odyssey_config("p", methods)["printer"].dump() == R"({"max_z":160.0})");
  for (const Json& odd : {Json::object(), Json{{"methods", 1}}, Json{{"methods", {{{"name", "move"}}}}}})
    CHECK(odyssey_config("p", odd)["printer"].dump() == R"({"max_z":0.0})");
}
