// contourd-bench: measures the performance that the contour core promises, compares it with other slicers,
// and prints one table. All figures are from this run; --help lists options that shorten it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>

#include "tests/bench/bench.hpp"
#include "tests/bench/process.hpp"
#include "tests/temporary_folder.hpp"

namespace contourd::bench {
namespace {

struct Options {
  bool quick = false, callgrind = false, no_peers = false;
  std::filesystem::path models, shared = CONTOURD_SHARED_DIR, json;
  std::vector<std::string> only;
  // Options for the program's own child processes:
  std::filesystem::path memory_of, model;
  std::string measured;
};

struct Group {
  std::string name;
  std::function<std::vector<Row>(const Bench&)> rows;
};

const std::vector<Group>& groups() {
  static const std::vector<Group> all{{"contours", contour_rows},
                                      {"print", print_rows},
                                      {"mask", mask_rows},
                                      {"load", load_rows},
                                      {"display", display_rows},
                                      {"allocations", allocation_rows},
                                      {"growth", growth_rows},
                                      {"supports", support_rows},
                                      {"dimming", dimming_rows},
                                      {"cure", cure_rows},
                                      {"instructions", instruction_rows}};
  return all;
}

void add_options(CLI::App& app, Options& options) {
  app.add_flag("--quick", options.quick, "Check that everything works: few repetitions, no other programs");
  app.add_flag("--no-peers", options.no_peers, "Do not run the other slicers");
  app.add_flag("--callgrind", options.callgrind, "Also count instructions (needs valgrind; takes minutes)");
  app.add_option("--json", options.json, "Also write the table to this file, as JSON");
  app.add_option("--models", options.models, "Keep generated models in this folder for the next run");
  app.add_option("--shared", options.shared,
                 "Folder whose models/ holds the models that cannot be generated");
  std::vector<std::string> names;
  for (const Group& group : groups())
    names.push_back(group.name);
  app.add_option("--only", options.only, "Measure only these groups of rows")->check(CLI::IsMember(names));
  // Hidden from the help: used for the program's child processes.
  app.add_option("--memory-of", options.memory_of)->group("");
  app.add_option("--measured", options.measured)->group("");
  app.add_option("--model", options.model)->group("");
}

bool is_wanted(const Options& options, const std::string& group) {
  if (!options.only.empty())
    return std::find(options.only.begin(), options.only.end(), group) != options.only.end();
  return group != "instructions" || options.callgrind;
}

void run(const Options& options) {
  if (is_wanted(options, "instructions") && !find_program("valgrind")) {
    throw std::runtime_error("valgrind is not installed; --callgrind needs it to count instructions");
  }
  std::unique_ptr<testing::TemporaryFolder> temporary;
  std::filesystem::path folder = options.models;
  if (folder.empty()) {
    temporary = std::make_unique<testing::TemporaryFolder>();
    folder = temporary->path();
  }
  const Models models(folder, options.shared, options.quick);
  const Bench bench{options.quick, !options.quick && !options.no_peers, models};
  std::vector<Row> rows;
  print_heading();
  for (const Group& group : groups()) {
    if (!is_wanted(options, group.name)) continue;
    const std::vector<Row> more = group.rows(bench);
    print_table_rows(more);
    rows.insert(rows.end(), more.begin(), more.end());
  }
  if (!options.json.empty()) write_json(options.json, rows, options.quick);
}

}  // namespace
}  // namespace contourd::bench

int main(int argc, char** argv) {
  using namespace contourd::bench;
  Options options;
  CLI::App app("Measures the contour core and compares it with other slicers");
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    if (!options.memory_of.empty()) {
      print_memory_of_first_mask(options.memory_of);
    } else if (!options.measured.empty()) {
      do_measured(options.measured, options.model);
    } else {
      run(options);
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "contourd-bench: {}\n", error.what());
    return 1;
  }
}
