"""The test bed: a virtual machine with a real kernel and our devices, what is put into it, and what it recorded."""
