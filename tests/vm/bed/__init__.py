"""The test bed: a virtual machine with a real kernel and our devices, the content of its guests, and the records of its
devices."""
