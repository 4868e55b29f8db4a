// The level of this processor, in a module without kernels, so that any processor runs it.
#define Py_LIMITED_API 0x030b0000
#include <Python.h>

#include "level.h"

static PyModuleDef definition = {
    PyModuleDef_HEAD_INIT,
    .m_name = "_processor",
    .m_doc = "The level of this processor.",
    .m_size = 0,
};

PyMODINIT_FUNC PyInit__processor(void) {
  PyObject* module = PyModule_Create(&definition);
  if (module && PyModule_AddIntConstant(module, "LEVEL", level_of_processor()) < 0) {
    Py_DECREF(module);
    return NULL;
  }
  return module;
}
