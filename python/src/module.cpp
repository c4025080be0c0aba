// SPDX-License-Identifier: Apache-2.0
// The module meltsim._core: everything that meltsim re-exports.
#include "builtin.hpp"
#include "common.hpp"
#include "host_world.hpp"

namespace {

const char* code_name(meltsim::ErrorCode code) {
  static const char* const names[] = {"invalid_argument", "version_mismatch", "no_device", "out_of_memory",
                                      "capacity",         "step_too_large",   "halted",    "corrupt_data",
                                      "interrupted",      "internal"};
  return names[static_cast<int>(code)];
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "The compiled part of meltsim.";
  // Held for as long as the process lives.
  static PyObject* const error_class =
      nb::object(nb::module_::import_("meltsim._error").attr("Error")).release().ptr();
  nb::register_exception_translator([](const std::exception_ptr& p, void*) {
    try {
      std::rethrow_exception(p);
    } catch (const meltsim_python::LibraryError& e) {
      nb::object instance = nb::handle(error_class)(meltsim_python::in_words_of_python(e.error.message),
                                                    code_name(e.error.code));
      PyErr_SetObject(error_class, instance.ptr());
    }
  });
  // A NumPy array does not tell Python's collector what it holds: one that outlives its stage, in the frames of an exception, would
  // keep the World until after the end.
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(&meltsim_python::HostWorld::release_all));
  meltsim_python::bind_shape(m);
  meltsim_python::bind_readings(m);
  meltsim_python::bind_world(m);
  m.def(
      "build_info",
      [] {
        const meltsim::BuildInfo info = meltsim::build_info();
        nb::dict d;
        d["version"] = info.version;
        d["cuda"] = info.cuda;
        d["devices"] = info.devices;
        d["cuda_reason"] = info.cuda_reason;
        d["cpu_threads"] = info.cpu_threads;
        return d;
      },
      nb::sig("def build_info() -> dict[str, typing.Any]"),
      "What this build contains and this machine offers.");
  m.def(
      "scenes", [] { return runner::builtin_names(); }, "Names of the built-in scenes.");
}
