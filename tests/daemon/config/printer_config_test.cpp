#include "daemon/config/printer_config.hpp"

#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"
#include "tests/daemon/config/resin_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// Returns a printer file with only the required keys.
json smallest_printer() {
  return json::parse(R"({
    "name": "test",
    "spool_folder": "spool",
    "control_socket": "control.sock",
    "resins_folder": "resins",
    "resin": "standard",
    "z_axis": {"travel_mm": 160, "microsteps_per_mm": 800, "homing_speed_mm_s": 5, "travel_speed_mm_s": 6,
               "acceleration_mm_s2": 25},
    "display": {"width_px": 1920, "height_px": 1080, "pixel_pitch_um": 50, "refresh_hz": 60},
    "projector": {"irradiance_mw_cm2": 5, "warm_up_s": 7},
    "hardware": "simulated"
  })");
}

// A folder with a printer file and its resins.
class PrinterFolder {
 public:
  explicit PrinterFolder(const json& printer = smallest_printer(),
                         const json& resin = shipped("resins/standard.json"))
      : file_(folder_.write_json("printer.json", printer)) {
    add_resin("standard", resin);
  }
  void add_resin(const std::string& name, const json& resin) {
    folder_.write_json("resins/" + name + ".json", resin);
  }
  [[nodiscard]] std::filesystem::path path() const { return folder_.path(); }
  [[nodiscard]] PrinterConfig load() const { return load_printer_config(file_); }
  [[nodiscard]] Complaints complaints() const {
    return complaints_of([&] { (void)load(); });
  }

 private:
  ConfigFolder folder_;
  std::filesystem::path file_;
};

Complaints printer_complaints_with(const std::string& pointer, const json& value) {
  json printer = smallest_printer();
  printer[json::json_pointer(pointer)] = value;
  return PrinterFolder(printer).complaints();
}

TEST_CASE("the shipped configurations load") {
  const std::filesystem::path folder = CONTOURD_CONFIG_DIR;
  const PrinterConfig real = load_printer_config(folder / "contourd.json");
  CHECK(real.spool_folder == "/var/spool/contourd");
  CHECK(real.control_socket == "/run/contourd/control.sock");
  CHECK(real.resins_folder == (folder / "resins").lexically_normal());
  CHECK(real.pace == Pace::Realtime);
  const PrinterConfig simulated = load_printer_config(folder / "simulated.json");
  CHECK(simulated.spool_folder == (folder / "spool").lexically_normal());
  CHECK(simulated.pace == Pace::Fast);
  CHECK(simulated.simulated.display.masks == (folder / "masks").lexically_normal());
  for (const PrinterConfig* printer : {&real, &simulated}) {
    CHECK(printer->resin == "standard");
    CHECK(printer->display_width == Pixels{1920});
    CHECK(printer->display_height == Pixels{1080});
    CHECK(printer->pixel_pitch == Micrometers{50.0});
    CHECK(printer->simulated.axis.microsteps_per_mm == 800.0);
    CHECK(printer->travel == Nanometers{160'000'000});
  }
}

TEST_CASE("every shipped resin loads and every shipped file names its schema") {
  const std::filesystem::path folder = CONTOURD_CONFIG_DIR;
  const PrinterConfig printer = load_printer_config(folder / "contourd.json");
  for (const auto& entry : std::filesystem::directory_iterator(folder / "resins")) {
    CHECK(find_resin(printer, entry.path().stem().string()).layer_height > Nanometers{0});
    const json resin = shipped("resins/" + entry.path().filename().string());
    CHECK(std::filesystem::exists(folder / "resins" / resin.at("$schema").get<std::string>()));
  }
  CHECK(std::filesystem::exists(folder / shipped("contourd.json").at("$schema").get<std::string>()));
  CHECK(std::filesystem::exists(folder / shipped("simulated.json").at("$schema").get<std::string>()));
}

TEST_CASE("every key of a printer file is read with its unit") {
  json printer = smallest_printer();
  printer["wait_for_plate_cleared"] = false;
  printer["ask_before"] = {"islands", "cracks"};
  printer["tiny_first_layer_percent"] = 2.5;
  printer["supports"] = "auto";
  printer["min_free_disk_mb"] = 7;
  printer["mask_budget_ms"] = 250;
  printer["manual"] = {{"light_limit_s", 12.5}, {"vat_depth_mm", 45}};
  printer["camera"] = {{"every_layers", 7}, {"time_limit_s", 30}, {"socket", "/run/camera"}};
  printer["reminders"] = {{"lamp", {{"lamp_h", 0.5}}}, {"film", {{"layers", 30'000}, {"prints", 60}}}};
  printer["z_axis"] = {{"travel_mm", 150.5},
                       {"microsteps_per_mm", 400.5},
                       {"homing_speed_mm_s", 3.5},
                       {"travel_speed_mm_s", 6.5},
                       {"acceleration_mm_s2", 30.5}};
  printer["display"] = {{"width_px", 1280}, {"height_px", 800}, {"pixel_pitch_um", 47.25},
                        {"mirror_x", true}, {"mirror_y", true}, {"anti_aliasing", false},
                        {"refresh_hz", 50}};
  printer["projector"] = {{"irradiance_mw_cm2", 4.25}, {"warm_up_s", 1.5}, {"reply_timeout_s", 3}};
  printer["simulation"] = {{"pace", "fast"},
                           {"masks_folder", "/m"},
                           {"start_height_mm", 12.5},
                           {"limit_switch", "stuck_closed"},
                           {"display_lost_after_frames", 3},
                           {"display_back_after_s", 5},
                           {"lid_opened_after_light_s", 7.5},
                           {"lid_open_s", 2},
                           {"projector_reply_ms", 2.5},
                           {"projector_silent_after_commands", 4}};
  const PrinterConfig config = PrinterFolder(printer).load();
  CHECK(config.name == "test");
  REQUIRE(config.camera);
  CHECK(config.camera->every_layers == 7);
  CHECK(config.camera->time_limit == 30s);
  CHECK(config.camera->socket == "/run/camera");
  CHECK_FALSE(config.wait_for_plate_cleared);
  CHECK(config.ask_before == std::vector<std::string>{"islands", "cracks"});
  CHECK(config.tiny_first_layer_percent == 2.5);
  CHECK(config.supports == SupportPolicy::Auto);
  CHECK(config.min_free_disk_bytes == 7'000'000);
  CHECK(config.mask_budget == std::chrono::milliseconds{250});
  CHECK(config.manual.light_limit == std::chrono::milliseconds{12'500});
  CHECK(config.manual.vat_depth == Nanometers{45'000'000});
  CHECK(config.reminders.lamp.lamp_h == 0.5);
  CHECK_FALSE(config.reminders.lamp.layers);
  CHECK(config.reminders.film.layers == 30'000);
  CHECK(config.reminders.film.prints == 60);
  CHECK_FALSE(config.reminders.vat.prints);
  CHECK(config.travel == Nanometers{150'500'000});
  CHECK(config.travel_speed == MillimetersPerSecond{6.5});
  CHECK(config.display_width == Pixels{1280});
  CHECK(config.display_height == Pixels{800});
  CHECK(config.pixel_pitch == Micrometers{47.25});
  CHECK(config.mirror_x);
  CHECK(config.mirror_y);
  CHECK_FALSE(config.anti_aliasing);
  CHECK(config.irradiance_mw_cm2 == 4.25);
  CHECK(config.pace == Pace::Fast);
  const SimulatedPrinterConfig& simulated = config.simulated;
  CHECK(simulated.axis.travel == Nanometers{150'500'000});
  CHECK(simulated.axis.microsteps_per_mm == 400.5);
  CHECK(simulated.axis.homing_speed == MillimetersPerSecond{3.5});
  CHECK(simulated.axis.acceleration == MillimetersPerSecondSquared{30.5});
  CHECK(simulated.axis.start_height == Nanometers{12'500'000});
  CHECK(simulated.axis.limit_switch == SimulatedAxisConfig::Switch::StuckClosed);
  CHECK(simulated.display.width == Pixels{1280});
  CHECK(simulated.display.height == Pixels{800});
  CHECK(simulated.display.frame == std::chrono::milliseconds{20});
  CHECK(simulated.display.masks == "/m");
  CHECK(simulated.display.lost_after_frames == 3);
  CHECK(simulated.display.back_after == std::chrono::seconds{5});
  CHECK(simulated.lid_opened_after_light == std::chrono::milliseconds{7500});
  CHECK(simulated.lid_open_for == std::chrono::seconds{2});
  CHECK(simulated.projector.warm_up == std::chrono::milliseconds{1500});
  CHECK(simulated.projector.reply == std::chrono::microseconds{2500});
  CHECK(simulated.projector.timeout == std::chrono::seconds{3});
  CHECK(simulated.projector.silent_after_commands == 4);
}

TEST_CASE("keys missing in a printer file get their defaults") {
  const PrinterConfig config = PrinterFolder().load();
  CHECK(config.wait_for_plate_cleared);
  CHECK(config.ask_before.empty());
  CHECK(config.tiny_first_layer_percent == 5);
  CHECK(config.supports == SupportPolicy::Off);
  CHECK(config.min_free_disk_bytes == 100'000'000);
  CHECK(config.mask_budget == std::chrono::milliseconds{1000});
  CHECK_FALSE(config.mirror_x);
  CHECK_FALSE(config.mirror_y);
  CHECK(config.anti_aliasing);
  CHECK(config.pace == Pace::Realtime);
  const SimulatedPrinterConfig machine_defaults;
  CHECK(config.simulated.axis.start_height == machine_defaults.axis.start_height);
  CHECK(config.simulated.axis.limit_switch == machine_defaults.axis.limit_switch);
  CHECK(config.simulated.projector.reply == machine_defaults.projector.reply);
  CHECK(config.simulated.projector.timeout == machine_defaults.projector.timeout);
  CHECK_FALSE(config.simulated.display.masks);
  CHECK_FALSE(config.simulated.display.lost_after_frames);
  CHECK_FALSE(config.simulated.display.back_after);
  CHECK_FALSE(config.simulated.lid_opened_after_light);
  CHECK_FALSE(config.simulated.projector.silent_after_commands);
}

TEST_CASE("a print may go on by itself after a power cut only with the limit switch at the top") {
  json printer = smallest_printer();
  CHECK_FALSE(PrinterFolder(printer).load().resumes_after_power_cut);
  printer["after_power_cut"] = "resume";
  const Complaints complaints = PrinterFolder(printer).complaints();
  REQUIRE(complaints.size() == 1);
  CHECK(complaints.front().find("/after_power_cut: \"resume\" needs z_axis/homes_upwards") !=
        std::string::npos);
  printer["z_axis"].update({{"homes_upwards", true}, {"switch_height_mm", 160}});
  CHECK(PrinterFolder(printer).load().resumes_after_power_cut);
  CHECK(PrinterFolder(printer).load().simulated.axis.homes_upwards);
}

TEST_CASE("relative paths start from the file's folder, whatever the working directory is") {
  const PrinterFolder folder;
  const PrinterConfig config = folder.load();
  CHECK(config.spool_folder == folder.path() / "spool");
  CHECK(config.control_socket == folder.path() / "control.sock");
  CHECK(config.job_ended_socket == "/run/contourd-job-ended.socket");
  CHECK_FALSE(config.metrics_file);
  CHECK_FALSE(config.camera);
  const auto relative = std::filesystem::relative(folder.path() / "printer.json");
  CHECK(load_printer_config(relative).spool_folder.is_absolute());
  json printer = smallest_printer();
  printer["spool_folder"] = "./x/../spool/";
  CHECK(PrinterFolder(printer).load().spool_folder.filename() == "spool");
}

TEST_CASE("a folder that the daemon could not use is reported when the configuration is read") {
  json printer = smallest_printer();
  printer["control_socket"] = "missing/control.sock";
  printer["spool_folder"] = "printer.json/deep/spool";
  const PrinterFolder folder(printer);
  const std::string file = (folder.path() / "printer.json").string();
  CHECK(folder.complaints() ==
        Complaints{"/control_socket: there is no folder " + (folder.path() / "missing").string(),
                   "/spool_folder: " + file + "/deep/spool cannot be created: " + file + " is not a folder"});
  // The folders of a printer elsewhere are not checked.
  CHECK(complaints_of([&] { (void)load_printer_config(file, Places::Elsewhere); }).empty());
  // The service's own folder in /run exists once the service runs.
  CHECK(printer_complaints_with("/control_socket", "/run/no-such-service/control.sock").empty());
  CHECK(printer_complaints_with("/spool_folder", "deep/er/spool").empty());
}

TEST_CASE("ten mistakes in a printer file are reported in ten lines") {
  json printer = smallest_printer();
  printer.erase("name");
  printer["resin"] = "../standard";
  printer["hardware"] = "imagined";
  printer["min_free_disk_mb"] = -3.7;
  printer["z_axis"]["travel_mm"] = 900;
  printer["z_axis"]["travl_mm"] = 160;
  printer["display"]["width_px"] = true;
  printer["display"]["mirror_x"] = "yes";
  printer["projector"] = 5;
  printer["simulation"] = {{"pace", "faster"}};
  const PrinterFolder folder(printer);
  CHECK(folder.complaints() ==
        Complaints{
            "/display/mirror_x: expected true or false, found the text \"yes\"",
            "/display/width_px: expected a whole number, found true",
            "/hardware: the text \"imagined\" is not one of \"simulated\", \"real\"",
            "/min_free_disk_mb: expected a whole number, found -3.7",
            "/name: this key is missing: Name of this printer, 1 to 100 characters",
            "/projector: expected an object, found 5",
            "/resin: \"../standard\" is not allowed: Name of the resin profile for jobs that name none, "
            "without "
            "'/' and with no '.' at its start",
            "/simulation/pace: the text \"faster\" is not one of \"realtime\", \"fast\"",
            "/z_axis/travel_mm: 900 is more than the limit, 500 mm",
            "/z_axis/travl_mm: there is no key \"travl_mm\" here; did you mean \"travel_mm\"?",
        });
  try {
    (void)folder.load();
    FAIL("it loaded");
  } catch (const ConfigError& error) {
    const std::string text = error.what();
    CHECK(std::count(text.begin(), text.end(), '\n') == 9);
    CHECK(text.starts_with((folder.path() / "printer.json").string() + ": /display/mirror_x: expected"));
  }
}

TEST_CASE("the mistakes of the printer and of its resin are reported together, each with its file") {
  json printer = smallest_printer();
  printer["display"]["width_px"] = 0;
  json resin = shipped("resins/standard.json");
  resin["lift_mm"] = -1;
  const PrinterFolder folder(printer, resin);
  const auto violations = violations_of([&] { (void)folder.load(); });
  REQUIRE(violations.size() == 2);
  CHECK(violations[0] == Violation{(folder.path() / "printer.json").string(), "/display/width_px",
                                   "0 is less than the least allowed, 1 px"});
  CHECK(violations[1] == Violation{(folder.path() / "resins/standard.json").string(), "/lift_mm",
                                   "-1 is less than the least allowed, 0.1 mm"});
}

TEST_CASE("the limits of a printer file are those of the schema") {
  CHECK(printer_complaints_with("/display/width_px", 16384).empty());
  CHECK(printer_complaints_with("/display/width_px", 16385) ==
        Complaints{"/display/width_px: 16385 is more than the limit, 16384 px"});
  CHECK(printer_complaints_with("/display/height_px", 0).size() == 1);
  CHECK(printer_complaints_with("/name", "").size() == 1);
  CHECK(printer_complaints_with("/projector/irradiance_mw_cm2", 0).size() == 1);
  CHECK(printer_complaints_with("/$schema", "anything").empty());
  CHECK(printer_complaints_with("/z_axis/$schema", "not here").size() == 1);
}

TEST_CASE("a limit is reported with its key's unit") {
  for (const auto& [pointer, limit] : {
           std::pair{"/z_axis/travel_mm", "500 mm"},
           {"/z_axis/microsteps_per_mm", "100000 per mm"},
           {"/z_axis/travel_speed_mm_s", "50 mm/s"},
           {"/z_axis/acceleration_mm_s2", "5000 mm/s2"},
           {"/display/pixel_pitch_um", "1000 um"},
           {"/display/height_px", "16384 px"},
           {"/display/refresh_hz", "240 Hz"},
           {"/projector/irradiance_mw_cm2", "1000 mW/cm²"},
           {"/projector/warm_up_s", "600 s"},
           {"/simulation/projector_reply_ms", "60000 ms"},
           {"/min_free_disk_mb", "1000000 MB"},
       }) {
    CHECK(printer_complaints_with(pointer, 2'000'000) ==
          Complaints{std::string(pointer) + ": 2000000 is more than the limit, " + limit});
  }
}

TEST_CASE("a memory limit is optional and must leave room for a model besides the program and its masks") {
  CHECK_FALSE(PrinterFolder(smallest_printer()).load().memory_limit_bytes);
  json printer = smallest_printer();
  printer["memory_limit_mb"] = 500;
  CHECK(PrinterFolder(printer).load().memory_limit_bytes == 500'000'000);
  CHECK(
      printer_complaints_with("/memory_limit_mb", 20) ==
      Complaints{"/memory_limit_mb: 20 MB leave no room for a model: contourd and the masks of this display "
                 "take 47 MB"});
  CHECK(printer_complaints_with("/memory_limit_mb", 47).empty());
  CHECK(printer_complaints_with("/memory_limit_mb", 0).size() == 1);
  CHECK(printer_complaints_with("/memory_limit_mb", "much").size() == 1);
}

TEST_CASE("the start height is within the travel, also when neither is written") {
  CHECK(printer_complaints_with("/simulation/start_height_mm", 160).empty());
  CHECK(printer_complaints_with("/simulation/start_height_mm", 160.5) ==
        Complaints{"/simulation/start_height_mm: 160.5 is more than z_axis/travel_mm, 160.0 mm"});
  CHECK(printer_complaints_with("/z_axis/travel_mm", 30).size() == 1);
  // A travel that is invalid by itself is one mistake, not two.
  CHECK(printer_complaints_with("/z_axis/travel_mm", -30).size() == 1);
}

TEST_CASE("a control socket whose absolute path is too long for a socket is refused") {
  CHECK(printer_complaints_with("/control_socket", "/" + std::string(106, 'x')).empty());
  CHECK(printer_complaints_with("/control_socket", "/" + std::string(107, 'x')) ==
        Complaints{"/control_socket: the absolute path is 108 bytes long; the limit for a socket is 107"});
  CHECK(printer_complaints_with("/camera", {{"socket", "/" + std::string(107, 'x')}}) ==
        Complaints{"/camera/socket: the absolute path is 108 bytes long; the limit for a socket is 107"});
  CHECK(printer_complaints_with("/job_ended_socket", "/" + std::string(107, 'x')) ==
        Complaints{"/job_ended_socket: the absolute path is 108 bytes long; the limit for a socket is 107"});
}

TEST_CASE("the resin's lift must be less than the printer's travel") {
  json resin = shipped("resins/standard.json");
  resin["lift_mm"] = 10;
  resin["second_lift_mm"] = 0;
  json printer = smallest_printer();
  printer["simulation"]["start_height_mm"] = 0;
  printer["z_axis"]["travel_mm"] = 10;
  CHECK(PrinterFolder(printer, resin).complaints() ==
        Complaints{"/lift_mm: 10 is not less than the printer's travel, 10 mm"});
  printer["z_axis"]["travel_mm"] = 10.5;
  CHECK(PrinterFolder(printer, resin).complaints().empty());
  resin["second_lift_mm"] = 0.5;
  CHECK(PrinterFolder(printer, resin).complaints() ==
        Complaints{"/lift_mm: 10 and second_lift_mm, 0.5, are not less than the printer's travel, 10.5 mm"});
}

TEST_CASE("a missing default resin is reported with the existing ones") {
  json printer = smallest_printer();
  printer["resin"] = "tough";
  PrinterFolder folder(printer);
  folder.add_resin("clear", shipped("resins/standard.json"));
  CHECK(folder.complaints() ==
        Complaints{"/resin: there is no resin profile \"tough\" in \"" + (folder.path() / "resins").string() +
                   "\"; there are \"clear\", \"standard\""});
}

TEST_CASE("gamma, threshold and the uniformity mask are read, and have no effect by default") {
  CHECK(PrinterFolder().load().tone == ToneCurve{});
  CHECK_FALSE(PrinterFolder().load().uniformity);
  json printer = smallest_printer();
  printer["display"]["width_px"] = 30;
  printer["display"]["height_px"] = 20;
  printer["display"]["gamma"] = 2.2;
  printer["display"]["threshold"] = 40;
  printer["display"]["uniformity_mask"] = "even.png";
  const PrinterFolder folder(printer);
  Mask even(Pixels{30}, Pixels{20});
  even.row(3)[4] = 200;
  write_png(folder.path() / "even.png", even);
  CHECK(folder.load().tone == ToneCurve{2.2, 40});
  CHECK(folder.load().uniformity == even);
}

TEST_CASE("a gamma that a light meter measured is multiplied by the resin's reciprocity exponent") {
  json printer = smallest_printer();
  printer["display"]["gamma"] = 2.5;
  ResinProfile resin = testing::load_resin(shipped("resins/standard.json"));
  resin.cure_irradiance = CureIrradiance{MilliwattsPerCm2{5}, 0.8};
  CHECK(tone_for(PrinterFolder(printer).load(), resin).gamma == 2.5);
  printer["display"]["gamma_of"] = "light";
  CHECK(tone_for(PrinterFolder(printer).load(), resin).gamma == Approx(2));
  resin.cure_irradiance.reset();
  CHECK(tone_for(PrinterFolder(printer).load(), resin).gamma == 2.5);
}

TEST_CASE("a pixel's light is read in pixels, and stays within its pixel by default") {
  CHECK(PrinterFolder().load().pixel_light == PixelLight{});
  json printer = smallest_printer();
  printer["display"]["pixel_pitch_um"] = 50;
  printer["display"]["pixel_light"] = {{{"sigma_um", 20}, {"share", 0.9}}, {{"sigma_um", 800}}};
  CHECK(PrinterFolder(printer).load().pixel_light == PixelLight{{{0.4, 0.9}, {16, 1}}});
  printer["display"]["pixel_light"][1]["sigma_um"] = 801;
  CHECK(PrinterFolder(printer).complaints() ==
        Complaints{"/display/pixel_light/1/sigma_um: 801 um are more than 16 pixels of 50 um, the widest "
                   "light that is computed"});
  printer["display"]["pixel_light"] = json::array();
  CHECK(PrinterFolder(printer).complaints().size() == 1);
}

TEST_CASE("a panel's bits of grey are read, and exposures are split if they are fewer than 8, the default") {
  CHECK(PrinterFolder().load().grey_bits == 8);
  CHECK_FALSE(PrinterFolder().load().splits_exposures());
  json printer = smallest_printer();
  for (const int bits : {1, 7, 8}) {
    printer["display"]["grey_bits"] = bits;
    const PrinterConfig config = PrinterFolder(printer).load();
    CHECK(config.grey_bits == bits);
    CHECK(config.splits_exposures() == (bits < 8));
  }
  for (const int bits : {0, 9}) {
    printer["display"]["grey_bits"] = bits;
    CHECK(PrinterFolder(printer).complaints().size() == 1);
  }
}

TEST_CASE("a resin is found by its name") {
  PrinterFolder folder;
  json tough = shipped("resins/standard.json");
  tough["exposure_ms"] = 4000;
  folder.add_resin("tough", tough);
  const ResinProfile resin = find_resin(folder.load(), "tough");
  CHECK(resin.name == "tough");
  CHECK(exposure_time(resin, resin.layer_height, 100, 5.0) == std::chrono::seconds{4});
}

TEST_CASE("a hidden name or one that leads out of the resins folder is not found, although the file exists") {
  PrinterFolder folder;
  folder.add_resin(".hidden", shipped("resins/standard.json"));
  folder.add_resin("../outside", shipped("resins/standard.json"));
  folder.add_resin("a/b", shipped("resins/standard.json"));
  const PrinterConfig printer = folder.load();
  using namespace std::string_view_literals;
  for (const std::string_view name :
       {""sv, "."sv, "../outside"sv, "/etc/passwd"sv, ".hidden"sv, "standard\0x"sv, "a/b"sv, "\xff\xfe"sv}) {
    const auto violations = violations_of([&] { (void)find_resin(printer, name); });
    REQUIRE(violations.size() == 1);
    CHECK(violations[0].file == printer.resins_folder.string());
    CHECK(violations[0].message.ends_with("there are \"standard\""));
  }
}

TEST_CASE("a missing resins folder is reported as unreadable") {
  const PrinterConfig printer = [] {
    const PrinterFolder folder;
    return folder.load();
  }();
  const Complaints complaints = complaints_of([&] { (void)find_resin(printer, "standard"); });
  REQUIRE(complaints.size() == 1);
  CHECK(complaints[0].ends_with("its folder cannot be read: No such file or directory"));
}

}  // namespace
}  // namespace contourd
