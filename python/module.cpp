// The extension module multireach._core, which python/multireach/__init__.py shows to users.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <opencv2/core.hpp>

#include "python/arrays.hpp"
#include "runtime/files.hpp"
#include "runtime/program.hpp"

PYBIND11_MODULE(_core, module) {
  using namespace multireach;
  namespace py = pybind11;
  spdlog::set_default_logger(spdlog::stderr_color_mt("multireach"));
  cv::setNumThreads(1);  // for identical output on every machine, as in the programs
  py::register_exception<InputError>(module, "InputError", PyExc_ValueError);
  py::register_exception<OutputError>(module, "OutputError", PyExc_OSError);
  module.attr("build") = this_build();
  python::bind_kinematics(module);
  python::bind_controller(module);
  python::bind_paper_law(module);
  python::bind_batch(module);
  python::bind_vision(module);
  python::bind_messages(module);
  python::bind_logs(module);
  python::bind_bus(module);
  python::bind_replay(module);
}
